// SPDX-License-Identifier: BSD-3-Clause
// Ranks that claim blocks of each other's shares.
#include "Ranks/Sharing/BlockClaims.h"
#include "Fixtures/Require.h"

#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>
#include <vector>

using namespace isosurface;

namespace
{

/// Counters of one process, which count how often they are used.
class LocalCounters : public SharedCounters
{
public:
  explicit LocalCounters(std::size_t ranks)
    : Values(ranks)
  {
  }
  Result<std::uint64_t> Add(int rank, std::uint64_t amount) override
  {
    ++this->Additions;
    if (this->FailsAt <= this->Additions)
    {
      return Status(StatusCode::IoError, "the network is down");
    }
    return this->Values[static_cast<std::size_t>(rank)].fetch_add(amount);
  }
  Result<std::vector<std::uint64_t>> Read(const std::vector<int>& ranks) override
  {
    this->Reads += ranks.size();
    std::vector<std::uint64_t> values;
    for (const int rank : ranks)
    {
      values.push_back(this->Values[static_cast<std::size_t>(rank)]);
    }
    return values;
  }

  std::atomic<std::size_t> Additions{ 0 };
  std::atomic<std::size_t> Reads{ 0 };
  std::size_t FailsAt = static_cast<std::size_t>(-1);

private:
  std::vector<std::atomic<std::uint64_t>> Values;
};

std::vector<std::size_t> MakeFirsts(const std::vector<std::size_t>& sizes)
{
  std::vector<std::size_t> firsts = { 0 };
  for (const std::size_t size : sizes)
  {
    firsts.push_back(firsts.back() + size);
  }
  return firsts;
}

/// What a rank takes until there is no more, and how often it was taken before.
std::size_t TakeAll(BlockClaims& claims, std::vector<std::atomic<int>>& taken)
{
  std::size_t count = 0;
  while (true)
  {
    const auto blocks = claims.Take();
    EXPECT_TRUE(blocks.IsOk());
    if (!blocks.IsOk() || blocks->empty())
    {
      return count;
    }
    for (const std::size_t block : *blocks)
    {
      ++taken.at(block);
    }
    count += blocks->size();
  }
}

void ExpectEachOnce(const std::vector<std::atomic<int>>& taken)
{
  for (std::size_t block = 0; block < taken.size(); ++block)
  {
    EXPECT_EQ(taken[block], 1) << "block " << block;
  }
}

} // namespace

TEST(BlockClaims, RanksThatTakeTurnsAtRandomClaimEachBlockOnce)
{
  std::mt19937 random(60);
  for (int trial = 0; trial < 300; ++trial)
  {
    std::vector<std::size_t> sizes(1 + random() % 7);
    for (std::size_t& size : sizes)
    {
      size = random() % 3 == 0 ? random() % 4 : random() % 400;
    }
    const std::vector<std::size_t> firsts = MakeFirsts(sizes);
    LocalCounters counters(sizes.size());
    std::vector<std::unique_ptr<BlockClaims>> ranks;
    for (std::size_t rank = 0; rank < sizes.size(); ++rank)
    {
      ranks.push_back(std::make_unique<BlockClaims>(
        counters, static_cast<int>(rank), firsts, 1 + static_cast<int>(random() % 3)));
    }
    std::vector<std::atomic<int>> taken(firsts.back());
    while (!ranks.empty())
    {
      // The first ones have more turns.
      const std::size_t turn = random() % (1 + random() % ranks.size());
      const auto blocks = Require(ranks[turn]->Take());
      for (const std::size_t block : blocks)
      {
        ++taken.at(block);
      }
      if (blocks.empty())
      {
        ranks.erase(ranks.begin() + static_cast<std::ptrdiff_t>(turn));
      }
    }
    ExpectEachOnce(taken);
  }
}

TEST(BlockClaims, RanksThatRunAtOnceClaimEachBlockOnce)
{
  for (const std::size_t ranks : { 2U, 3U, 4U, 7U })
  {
    const std::vector<std::size_t> firsts = MakeFirsts(std::vector<std::size_t>(ranks, 5000));
    LocalCounters counters(ranks);
    std::vector<std::atomic<int>> taken(firsts.back());
    std::vector<std::thread> threads;
    for (std::size_t rank = 0; rank < ranks; ++rank)
    {
      threads.emplace_back(
        [&, rank]
        {
          BlockClaims claims(counters, static_cast<int>(rank), firsts, 1);
          TakeAll(claims, taken);
        });
    }
    for (std::thread& thread : threads)
    {
      thread.join();
    }
    ExpectEachOnce(taken);
  }
}

TEST(BlockClaims, OthersTakeAllButWhatAHeldRankHasClaimed)
{
  const std::vector<std::size_t> firsts = MakeFirsts({ 500, 500, 500, 500 });
  LocalCounters counters(4);
  std::vector<std::atomic<int>> taken(2000);
  BlockClaims held(counters, 2, firsts, 1);
  const auto batch = Require(held.Take());
  EXPECT_EQ(batch, (std::vector<std::size_t>{ 1000, 1001, 1002, 1003 })) << "its first blocks";
  std::size_t ofOthers = 0;
  for (const int rank : { 0, 1, 3 })
  {
    std::size_t announced = 0;
    BlockClaims claims(counters, rank, firsts, 1,
      [&](std::size_t begin, std::size_t end) { announced += end - begin; });
    const std::size_t count = TakeAll(claims, taken);
    EXPECT_EQ(announced, rank == 0 ? count - 500 : 0) << "the first one leaves nothing";
    ofOthers += count;
  }
  EXPECT_EQ(ofOthers, 1996u);
  EXPECT_EQ(TakeAll(held, taken), 0u);
  for (const std::size_t block : batch)
  {
    ++taken[block];
  }
  ExpectEachOnce(taken);
}

TEST(BlockClaims, ARankThatHasTakenItsShareTakesFromTheEndOfTheLongestOne)
{
  const std::vector<std::size_t> firsts = MakeFirsts({ 0, 50, 400, 90 });
  LocalCounters counters(4);
  BlockClaims claims(counters, 0, firsts, 1);
  const auto blocks = Require(claims.Take());
  EXPECT_EQ(blocks.size(), 32u) << "at most 32 a thread";
  EXPECT_EQ(blocks.front(), 50u + 400u - 32u);
  EXPECT_EQ(blocks.back(), 449u);
}

TEST(BlockClaims, NobodyTakesWhatARankHasWithdrawn)
{
  const std::vector<std::size_t> firsts = MakeFirsts({ 300, 300, 300 });
  LocalCounters counters(3);
  std::vector<std::atomic<int>> taken(900);
  BlockClaims failed(counters, 1, firsts, 2);
  ASSERT_TRUE(failed.Take().IsOk());
  BlockClaims::Withdraw(counters, 1);
  for (const int rank : { 0, 2 })
  {
    BlockClaims claims(counters, rank, firsts, 2);
    TakeAll(claims, taken);
  }
  for (std::size_t block = 0; block < 900; ++block)
  {
    EXPECT_EQ(taken[block], block / 300 == 1 ? 0 : 1) << "block " << block;
  }
}

// 1,000 blocks take about a second, an addition of a counter a microsecond.
TEST(BlockClaims, CostsFewAdditionsIfAllAreEquallyFast)
{
  constexpr std::size_t ranks = 4;
  const std::vector<std::size_t> firsts = MakeFirsts(std::vector<std::size_t>(ranks, 1000));
  LocalCounters counters(ranks);
  std::vector<BlockClaims*> claims;
  std::vector<std::unique_ptr<BlockClaims>> owned;
  std::vector<std::size_t> busy(ranks); ///< blocks that a rank still has to extract
  for (std::size_t rank = 0; rank < ranks; ++rank)
  {
    owned.push_back(std::make_unique<BlockClaims>(counters, static_cast<int>(rank), firsts, 1));
  }
  std::size_t moves = 0;
  std::size_t ended = 0;
  while (ended < ranks)
  {
    ended = 0;
    for (std::size_t rank = 0; rank < ranks; ++rank)
    {
      if (busy[rank] > 0)
      {
        --busy[rank];
        continue;
      }
      const auto blocks = Require(owned[rank]->Take());
      busy[rank] = blocks.size();
      ended += blocks.empty() ? 1 : 0;
      moves += !blocks.empty() && blocks.front() / 1000 != rank ? blocks.size() : 0;
    }
  }
  EXPECT_LE(counters.Additions, ranks * 320);
  EXPECT_LE(counters.Reads, ranks * ranks);
  EXPECT_EQ(moves, 0u) << "ranks keep their own blocks, which their caches have";
}

TEST(BlockClaims, TellsTheErrorOfACounter)
{
  for (const std::size_t failsAt : { 1U, 5U })
  {
    const std::vector<std::size_t> firsts = MakeFirsts({ 3, 30 });
    LocalCounters counters(2);
    counters.FailsAt = failsAt;
    BlockClaims claims(counters, 0, firsts, 1);
    Status status;
    for (int n = 0; n < 10 && status.IsOk(); ++n)
    {
      status = claims.Take().GetStatus();
    }
    EXPECT_EQ(status.GetMessage(), "the network is down");
  }
}
