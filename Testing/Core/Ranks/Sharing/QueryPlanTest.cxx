// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Sharing/QueryPlan.h"

#include "Fixtures/VolumeOnDisk.h"

#include <algorithm>
#include <limits>
#include <tuple>

using namespace isosurface;

namespace
{

constexpr double Isovalue = 50;

QueryPlan Plan(
  BlockedVolume& volume, int rank, int ranks, PlannedShares shares = PlannedShares::Own)
{
  QueryStatistics statistics;
  auto plan =
    PlanQuery(volume, { { 0, 0, { Isovalue }, {} }, rank, ranks, {} }, 0, statistics, shares);
  EXPECT_TRUE(plan.IsOk()) << plan.GetStatus().GetMessage();
  EXPECT_EQ(statistics.ActiveBlocks, plan->GetOwnEnd() - plan->GetOwnBegin());
  return std::move(*plan);
}

std::vector<std::tuple<std::uint32_t, std::uint32_t>> Sort(
  const std::vector<BlockReference>& blocks)
{
  std::vector<std::tuple<std::uint32_t, std::uint32_t>> places;
  for (const BlockReference& block : blocks)
  {
    places.emplace_back(block.Store, block.Ordinal);
  }
  std::sort(places.begin(), places.end());
  return places;
}

} // namespace

TEST(QueryPlan, RanksShareTheActiveBlocksOfAnyNumberOfStores)
{
  const auto volume = MakeVolume<std::uint8_t>({ 70, 60, 50 });
  for (const std::uint32_t stores : { 1u, 4u, 7u })
  {
    MemoryDisk disk;
    const auto opened = WriteAndOpen(disk, volume, MakeSettings(16, stores), 3);
    ASSERT_NE(opened, nullptr);
    const auto expected = Sort(Plan(*opened, 0, 1).Blocks);
    for (int ranks = 1; ranks <= 20; ++ranks)
    {
      std::vector<BlockReference> active;
      std::size_t fewest = std::numeric_limits<std::size_t>::max();
      std::size_t most = 0;
      for (int rank = 0; rank < ranks; ++rank)
      {
        const QueryPlan mine = Plan(*opened, rank, ranks);
        active.insert(active.end(), mine.Blocks.begin(), mine.Blocks.end());
        fewest = std::min(fewest, mine.Blocks.size());
        most = std::max(most, mine.Blocks.size());
      }
      EXPECT_EQ(Sort(active), expected);
      if (stores == 1)
      {
        EXPECT_LE(most - fewest, 1u);
      }
    }
  }
}

TEST(QueryPlan, AllRanksKnowTheSharesThatEachWouldBeDealt)
{
  MemoryDisk disk;
  const auto opened =
    WriteAndOpen(disk, MakeVolume<std::uint8_t>({ 70, 60, 50 }), MakeSettings(16, 4), 3);
  ASSERT_NE(opened, nullptr);
  opened->SetLocalStores(false);
  for (const int ranks : { 1, 2, 3, 4, 7 })
  {
    const QueryPlan all = Plan(*opened, 0, ranks, PlannedShares::All);
    for (int rank = 0; rank < ranks; ++rank)
    {
      const QueryPlan same = Plan(*opened, rank, ranks, PlannedShares::All);
      EXPECT_EQ(same.Blocks, all.Blocks);
      EXPECT_EQ(same.Firsts, all.Firsts);
      const std::vector<BlockReference> own(
        same.Blocks.begin() + static_cast<std::ptrdiff_t>(same.GetOwnBegin()),
        same.Blocks.begin() + static_cast<std::ptrdiff_t>(same.GetOwnEnd()));
      EXPECT_EQ(own, Plan(*opened, rank, ranks).Blocks);
    }
  }
}
