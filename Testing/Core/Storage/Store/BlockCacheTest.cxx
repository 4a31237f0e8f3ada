// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockCache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

using namespace isosurface;

namespace
{

Result<std::shared_ptr<const DecodedBlock>> MakeBlock(std::int64_t number, std::size_t bytes)
{
  auto block = std::make_shared<DecodedBlock>();
  block->Block = number;
  block->Bytes = Buffer<std::uint8_t>(bytes);
  return std::shared_ptr<const DecodedBlock>(block);
}

/// Gets a block of 1000 bytes; returns whether it was in the cache.
bool Ask(BlockCache& cache, std::int64_t number, std::size_t bytes = 1000)
{
  bool hit = false;
  const auto block = cache.Get(
    { 1, number, 0, 0 }, [&] { return MakeBlock(number, bytes); }, hit);
  EXPECT_TRUE(block.IsOk());
  EXPECT_EQ((*block)->Block, number);
  EXPECT_LE(cache.GetSize(), cache.GetBudget());
  return hit;
}

} // namespace

TEST(BlockCache, KeepsTheMostRecentlyUsedBlocksWithinItsBudget)
{
  BlockCache cache(4000); // three blocks and what they cost beside their samples
  for (const std::int64_t block : { 1, 2, 3 })
  {
    EXPECT_FALSE(Ask(cache, block));
  }
  EXPECT_TRUE(Ask(cache, 1));
  EXPECT_FALSE(Ask(cache, 4)); // 2 goes
  EXPECT_TRUE(Ask(cache, 1));
  EXPECT_TRUE(Ask(cache, 3));
  EXPECT_TRUE(Ask(cache, 4));
  EXPECT_FALSE(Ask(cache, 2));
}

TEST(BlockCache, KeepsBlocksOfAQueryLargerThanItsBudget)
{
  BlockCache cache(4000); // three blocks
  const auto sweep = [&cache](std::int64_t first)
  {
    std::vector<BlockCacheKey> keys;
    for (std::int64_t block = first; block < first + 5; ++block)
    {
      keys.push_back({ 1, block, 0, 0 });
    }
    cache.Expect(keys);
    int hits = 0;
    for (const BlockCacheKey& key : keys)
    {
      hits += Ask(cache, key.Block) ? 1 : 0;
    }
    return hits;
  };
  EXPECT_EQ(sweep(1), 0); // keeps 1, 2, 3
  EXPECT_EQ(sweep(1), 3);
  EXPECT_EQ(sweep(2), 2); // 4 takes the place of 1
  EXPECT_EQ(sweep(2), 3);
  EXPECT_EQ(sweep(100), 0);
  EXPECT_EQ(sweep(100), 3);
  // Blocks that no query expects enter the cache as well.
  EXPECT_FALSE(Ask(cache, 1));
  EXPECT_TRUE(Ask(cache, 1));
  cache.SetBudget(0);
  EXPECT_EQ(cache.GetSize(), 0u);
}

TEST(BlockCache, DistinguishesKeys)
{
  BlockCache cache(100000);
  bool hit = false;
  const auto load = [] { return MakeBlock(5, 10); };
  EXPECT_TRUE(cache.Get({ 1, 5, 0, 0 }, load, hit).IsOk());
  for (const BlockCacheKey& key :
    { BlockCacheKey{ 2, 5, 0, 0 }, { 1, 6, 0, 0 }, { 1, 5, 1, 0 }, { 1, 5, 0, 1 } })
  {
    EXPECT_TRUE(cache.Get(key, load, hit).IsOk());
    EXPECT_FALSE(hit);
  }
  EXPECT_TRUE(cache.Get({ 1, 5, 0, 0 }, load, hit).IsOk());
  EXPECT_TRUE(hit);
}

TEST(BlockCache, DoesNotKeepABlockLargerThanItsBudget)
{
  BlockCache cache(4000);
  EXPECT_FALSE(Ask(cache, 1));
  EXPECT_FALSE(Ask(cache, 2, 5000));
  EXPECT_FALSE(Ask(cache, 2, 5000));
  EXPECT_TRUE(Ask(cache, 1));
  cache.SetBudget(0);
  EXPECT_EQ(cache.GetSize(), 0u);
  EXPECT_FALSE(Ask(cache, 1));
  EXPECT_FALSE(Ask(cache, 1));
}

TEST(BlockCache, LeavesHeldBlocksAlive)
{
  BlockCache cache(4000);
  bool hit = false;
  const auto held = cache.Get(
    { 1, 1, 0, 0 }, [] { return MakeBlock(1, 1000); }, hit);
  cache.Clear();
  EXPECT_EQ(cache.GetSize(), 0u);
  ASSERT_TRUE(held.IsOk());
  EXPECT_EQ((*held)->Bytes.GetSize(), 1000u);
}

TEST(BlockCache, DoesNotKeepFailures)
{
  BlockCache cache(4000);
  bool hit = false;
  const auto failed = cache.Get(
    { 1, 1, 0, 0 },
    []() -> Result<std::shared_ptr<const DecodedBlock>>
    { return Status(StatusCode::IoError, "no"); },
    hit);
  EXPECT_EQ(failed.GetStatus().GetMessage(), "no");
  EXPECT_THROW(
    static_cast<void>(cache.Get(
      { 1, 1, 0, 0 },
      []() -> Result<std::shared_ptr<const DecodedBlock>> { throw std::bad_alloc(); }, hit)),
    std::bad_alloc);
  EXPECT_FALSE(Ask(cache, 1));
  EXPECT_TRUE(Ask(cache, 1));
}

TEST(BlockCache, LoadsABlockOnceForAllThreads)
{
  BlockCache cache(1 << 20);
  std::atomic<int> loads{ 0 };
  std::atomic<int> hits{ 0 };
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 8; ++thread)
  {
    threads.emplace_back(
      [&]
      {
        for (std::int64_t block = 0; block < 200; ++block)
        {
          bool hit = false;
          const auto result = cache.Get(
            { 1, block, 0, 0 },
            [&]
            {
              ++loads;
              std::this_thread::yield();
              return MakeBlock(block, 100);
            },
            hit);
          EXPECT_TRUE(result.IsOk());
          EXPECT_EQ((*result)->Block, block);
          hits += hit;
        }
      });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(loads, 200);
  EXPECT_EQ(hits, 7 * 200);
}

TEST(BlockCache, DropsTheBlocksOfADatasetWithItsLastUser)
{
  BlockCache cache(1 << 20);
  cache.Retain(1);
  cache.Retain(1);
  EXPECT_FALSE(Ask(cache, 7));
  cache.Expect({ { 1, 8, 0, 0 } });
  EXPECT_FALSE(Ask(cache, 8));
  bool hit = false;
  ASSERT_TRUE(cache
                .Get(
                  { 2, 7, 0, 0 }, [] { return MakeBlock(7, 1000); }, hit)
                .IsOk());
  const std::uint64_t all = cache.GetSize();
  cache.Release(1);
  EXPECT_EQ(cache.GetSize(), all);
  EXPECT_TRUE(Ask(cache, 7));
  cache.Release(1);
  EXPECT_EQ(cache.GetSize(), all / 3);
  EXPECT_FALSE(cache.Contains({ 1, 7, 0, 0 }));
  EXPECT_FALSE(cache.Contains({ 1, 8, 0, 0 }));
  EXPECT_TRUE(cache.Contains({ 2, 7, 0, 0 }));
}
