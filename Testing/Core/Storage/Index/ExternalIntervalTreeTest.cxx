// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/LongTests.h"
#include "Fixtures/Require.h"
#include "IntervalSets.h"

#include <atomic>
#include <memory>
#include <thread>

using namespace isosurface;

namespace
{

using TreePointer = std::unique_ptr<ExternalIntervalTree>;

TreePointer MakeTree(MemoryDisk& disk, const IntervalVector& intervals,
  std::uint32_t pageSize = PagedFile::DefaultPageSize, std::size_t cacheBytes = 0)
{
  const Status written = WriteTree(disk, "tree", intervals, TestMemoryLimit, pageSize);
  EXPECT_TRUE(written.IsOk()) << written.GetMessage();
  auto tree = ExternalIntervalTree::Open(disk, "tree", cacheBytes);
  EXPECT_TRUE(tree.IsOk()) << tree.GetStatus().GetMessage();
  return tree.IsOk() ? std::move(*tree) : nullptr;
}

} // namespace

TEST(ExternalIntervalTree, StabbingQueryEqualsBruteForce)
{
  // 21 sets x 5,000 = 105,000 queries; in short tests a fifth of these.
  const int divisor = LongTests ? 1 : 5;
  for (const IntervalSet& set : MakeIntervalSets())
  {
    for (const auto& [count, queries] : { std::pair(0, 50), std::pair(1, 150), std::pair(204, 300),
           std::pair(205, 500), std::pair(3000, 3000), std::pair(12000, 1000) })
    {
      MemoryDisk disk;
      const IntervalVector intervals = set.MakeAll(static_cast<std::uint64_t>(count));
      const TreePointer tree = MakeTree(disk, intervals);
      ASSERT_TRUE(tree);
      ASSERT_EQ(tree->GetCount(), intervals.size());
      std::mt19937_64 random(1);
      PageStatistics statistics;
      std::uint64_t found = 0;
      for (int query = 0; query < queries / divisor; ++query)
      {
        const ValueKey key = MakeQueryKey(intervals, random);
        ASSERT_EQ(CompareWithBruteForce(*tree, intervals, key, key, statistics, found), "")
          << set.Name << " " << count;
      }
    }
  }
}

TEST(ExternalIntervalTree, OverlapQueryEqualsBruteForce)
{
  for (const IntervalSet& set : MakeIntervalSets())
  {
    for (const auto& [count, queries] :
      { std::pair(0, 50), std::pair(1, 100), std::pair(500, 300), std::pair(9000, 400) })
    {
      MemoryDisk disk;
      const IntervalVector intervals = set.MakeAll(static_cast<std::uint64_t>(count));
      const TreePointer tree = MakeTree(disk, intervals);
      ASSERT_TRUE(tree);
      std::mt19937_64 random(2);
      PageStatistics statistics;
      std::uint64_t found = 0;
      for (int query = 0; query < queries; ++query)
      {
        ValueKey low = MakeQueryKey(intervals, random);
        ValueKey high = query % 3 ? MakeQueryKey(intervals, random) : low + random() % 8;
        if (low > high)
        {
          std::swap(low, high);
        }
        ASSERT_EQ(CompareWithBruteForce(*tree, intervals, low, high, statistics, found), "")
          << set.Name << " " << count;
      }
      ASSERT_EQ(CompareWithBruteForce(*tree, intervals, 0, MaximumKey, statistics, found), "");
      ASSERT_EQ(found, intervals.size());
    }
  }
}

TEST(ExternalIntervalTree, LargerPagesGiveTheSameAnswers)
{
  for (const std::uint32_t pageSize : { 8192u, 16384u })
  {
    for (const IntervalSet& set : MakeIntervalSets())
    {
      MemoryDisk disk;
      const IntervalVector intervals = set.MakeAll(5000);
      const TreePointer tree = MakeTree(disk, intervals, pageSize);
      ASSERT_TRUE(tree);
      std::mt19937_64 random(3);
      PageStatistics statistics;
      std::uint64_t found = 0;
      for (int query = 0; query < 100; ++query)
      {
        const ValueKey low = MakeQueryKey(intervals, random);
        const ValueKey high = std::max(low, MakeQueryKey(intervals, random));
        ASSERT_EQ(CompareWithBruteForce(*tree, intervals, low, low, statistics, found), "");
        ASSERT_EQ(CompareWithBruteForce(*tree, intervals, low, high, statistics, found), "");
      }
    }
  }
}

TEST(ExternalIntervalTree, AnEmptyRangeOverlapsNothing)
{
  MemoryDisk disk;
  const TreePointer tree = MakeTree(disk, { { 5, 9, 0 } });
  ASSERT_TRUE(tree);
  PageStatistics statistics;
  int found = 0;
  ASSERT_TRUE(tree
                ->FindOverlapping(
                  8, 7, [&](const KeyInterval&) { ++found; }, statistics)
                .IsOk());
  EXPECT_EQ(found, 0);
}

TEST(ExternalIntervalTree, TheCacheSavesReadsWithinItsBudget)
{
  MemoryDisk disk;
  const IntervalVector intervals = MakeIntervalSets()[0].MakeAll(20000);
  ASSERT_TRUE(WriteTree(disk, "tree", intervals).IsOk());
  PageStatistics first, second;
  std::uint64_t found = 0;
  auto large = Require(ExternalIntervalTree::Open(disk, "tree", std::size_t(64) << 20));
  EXPECT_EQ(CompareWithBruteForce(*large, intervals, 5, MaximumKey / 2, first, found), "");
  EXPECT_EQ(CompareWithBruteForce(*large, intervals, 5, MaximumKey / 2, second, found), "");
  EXPECT_GT(first.PageReads, 0u);
  EXPECT_EQ(second.PageReads, 0u);
  EXPECT_EQ(second.CacheHits, first.PageReads + first.CacheHits);

  // With room for two pages only, answers remain right, and a long query evicts the pages of a
  // short one.
  auto small = Require(ExternalIntervalTree::Open(disk, "tree", 10000));
  PageStatistics third;
  EXPECT_EQ(CompareWithBruteForce(*small, intervals, 5, MaximumKey / 2, third, found), "");
  EXPECT_EQ(CompareWithBruteForce(*small, intervals, 5, MaximumKey / 2, third, found), "");
  EXPECT_GE(third.PageReads + 4, 2 * first.PageReads);
}

TEST(ExternalIntervalTree, ManyThreadsMayQueryOneTree)
{
  MemoryDisk disk;
  const IntervalVector intervals = MakeIntervalSets()[0].MakeAll(5000);
  const TreePointer tree = MakeTree(disk, intervals, 4096, 40000);
  ASSERT_TRUE(tree);
  std::atomic<int> faults(0);
  std::vector<std::thread> threads;
  for (unsigned seed = 0; seed < 4; ++seed)
  {
    threads.emplace_back(
      [&, seed]
      {
        std::mt19937_64 random(seed);
        PageStatistics statistics;
        std::uint64_t found = 0;
        for (int query = 0; query < 100; ++query)
        {
          const ValueKey key = MakeQueryKey(intervals, random);
          faults += !CompareWithBruteForce(*tree, intervals, key, key, statistics, found).empty();
        }
      });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(faults, 0);
}
