// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockDealing.h"

#include "Fixtures/VolumeOnDisk.h"
#include "Store/BlockedVolume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

using namespace isosurface;

namespace
{

constexpr int BlockSize = 16;

// Sheets of many directions and distances, which fill a part of the volume.
SampleVolume<std::uint8_t> MakeSheets(const Index3& dimensions)
{
  return SampleVolume<std::uint8_t>(dimensions,
    [](std::int64_t i, std::int64_t j, std::int64_t k)
    {
      const double x = static_cast<double>(i);
      const double y = static_cast<double>(j);
      const double z = static_cast<double>(k);
      return 128 + 60 * std::sin(0.09 * x + 0.02 * y) + 40 * std::cos(0.07 * y - 0.05 * z) +
        25 * std::sin(0.11 * z + 0.03 * x * y / 100);
    });
}

// The cells of a block that an isosurface passes, which it has about two triangles in.
std::uint64_t CountCrossedCells(
  const SampleVolume<std::uint8_t>& volume, const VertexBox& box, double isovalue)
{
  std::uint64_t count = 0;
  for (std::int64_t k = box.Low[2]; k + 1 < box.High[2]; ++k)
  {
    for (std::int64_t j = box.Low[1]; j + 1 < box.High[1]; ++j)
    {
      for (std::int64_t i = box.Low[0]; i + 1 < box.High[0]; ++i)
      {
        int inside = 0;
        for (std::int64_t n = 0; n < 8; ++n)
        {
          inside += volume.At(i + n % 2, j + n / 2 % 2, k + n / 4) >= isovalue ? 1 : 0;
        }
        count += inside > 0 && inside < 8 ? 1 : 0;
      }
    }
  }
  return count;
}

} // namespace

TEST(BlockDealing, EveryActiveBlockIsThatOfOneRankAtEveryIsovalue)
{
  const auto volume = MakeSheets({ 100, 81, 70 });
  for (const std::uint32_t stores : { 1u, 4u, 7u })
  {
    MemoryDisk disk;
    WriteVolumeOk(disk, volume, MakeSettings(BlockSize, stores), 3);
    const auto opened = OpenVolume(disk);
    ASSERT_NE(opened, nullptr);
    opened->DealBlocks(true);
    for (const int ranks : { 1, 2, 3, 5, 16, 20 })
    {
      std::vector<int> owners(
        static_cast<std::size_t>(opened->GetBlockGrid().GetNumberOfBlocks()), -1);
      for (const double isovalue : { 90.0, 128.0, 129.5 })
      {
        QueryStatistics statistics;
        const auto all = opened->FindActiveBlocks(0, 0, { isovalue }, 0, 1, statistics);
        std::size_t found = 0;
        for (int rank = 0; rank < ranks; ++rank)
        {
          const auto mine = opened->FindActiveBlocks(0, 0, { isovalue }, rank, ranks, statistics);
          ASSERT_TRUE(mine.IsOk());
          found += mine->size();
          for (const BlockReference& block : *mine)
          {
            int& owner = owners[static_cast<std::size_t>(block.Block)];
            EXPECT_TRUE(owner == -1 || owner == rank);
            owner = rank;
            EXPECT_NE(std::find(all->begin(), all->end(), block), all->end());
          }
        }
        EXPECT_EQ(found, all->size());
        EXPECT_GT(found, 50u);
      }
    }
  }
}

TEST(BlockDealing, RanksHaveEqualPartsOfASurfaceWhateverTheStores)
{
  const auto volume = MakeSheets({ 209, 209, 177 });
  for (const std::uint32_t stores : { 1u, 2u, 3u, 16u })
  {
    MemoryDisk disk;
    WriteVolumeOk(disk, volume, MakeSettings(BlockSize, stores), 2);
    const auto opened = OpenVolume(disk);
    ASSERT_NE(opened, nullptr);
    opened->DealBlocks(true);
    for (const double isovalue : { 100.0, 128.0 })
    {
      QueryStatistics statistics;
      const auto all = opened->FindActiveBlocks(0, 0, { isovalue }, 0, 1, statistics);
      std::vector<std::uint64_t> cells(
        static_cast<std::size_t>(opened->GetBlockGrid().GetNumberOfBlocks()));
      std::uint64_t sum = 0;
      for (const BlockReference& block : *all)
      {
        std::uint64_t& count = cells[static_cast<std::size_t>(block.Block)];
        count =
          CountCrossedCells(volume, opened->GetBlockGrid().GetVertices(block.Block), isovalue);
        sum += count;
      }
      for (int ranks = 2; ranks <= 16 && all->size() >= 100 * static_cast<std::size_t>(ranks);
           ++ranks)
      {
        std::uint64_t most = 0;
        for (int rank = 0; rank < ranks; ++rank)
        {
          std::uint64_t mine = 0;
          const auto blocks = opened->FindActiveBlocks(0, 0, { isovalue }, rank, ranks, statistics);
          ASSERT_TRUE(blocks.IsOk());
          for (const BlockReference& block : *blocks)
          {
            mine += cells[static_cast<std::size_t>(block.Block)];
          }
          most = std::max(most, mine);
        }
        // These sheets are as regular as the lattice, which real surfaces are not.
        const double bound = all->size() >= 300 * static_cast<std::size_t>(ranks) ? 1.10 : 1.20;
        EXPECT_LE(static_cast<double>(most) * ranks / static_cast<double>(sum), bound)
          << ranks << " ranks, " << stores << " stores, " << all->size() << " blocks";
      }
      EXPECT_GE(all->size(), 1000u);
    }
  }
}

TEST(BlockDealing, NeighboursOnAnyAxisAreOfDifferentRanks)
{
  for (std::uint32_t ranks = 2; ranks <= 200; ++ranks)
  {
    const BlockDealing dealing(ranks);
    const std::uint32_t rank = dealing.FindRank({ 7, 8, 9 });
    EXPECT_LT(rank, ranks);
    EXPECT_NE(dealing.FindRank({ 8, 8, 9 }), rank);
    EXPECT_NE(dealing.FindRank({ 7, 9, 9 }), rank);
    EXPECT_NE(dealing.FindRank({ 7, 8, 10 }), rank);
  }
}
