// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/BlockAssembly.h"
#include "Fixtures/VolumeOnDisk.h"

using namespace isosurface;

namespace
{

std::vector<BlockReference> FindBlocks(BlockedVolume& volume, const BlockBox& box, int level = 0)
{
  QueryStatistics statistics;
  auto all = volume.ListBlocks(0, statistics, level);
  EXPECT_TRUE(all.IsOk());
  std::vector<BlockReference> blocks;
  for (const BlockReference& block : *all)
  {
    if (box.Contains(volume.FindLevel(level).Grid->GetBlockCoordinates(block.Block)))
    {
      blocks.push_back(block);
    }
  }
  return blocks;
}

} // namespace

TEST(BlockAssembly, SlabsOfAllPiecesAreTheSubsampledVolume)
{
  for (const Index3& size :
    { Index3{ 70, 33, 50 }, Index3{ 17, 40, 1 }, Index3{ 3, 2, 66 }, Index3{ 65, 65, 18 } })
  {
    const auto source = MakeVolume<std::int16_t>(size);
    for (const int blockSize : { 16, 32 })
    {
      MemoryDisk disk;
      const auto volume = WriteAndOpen(disk, source, MakeSettings(blockSize, 3));
      for (int level = 0; level < volume->GetNumberOfLevels(); ++level)
      {
        const StoredLevel stored = volume->FindLevel(level);
        const BlockGrid& grid = *stored.Grid;
        for (const int pieces : { 1, 2, 3, 7 })
        {
          std::int64_t cells = 0;
          for (int piece = 0; piece < pieces; ++piece)
          {
            const BlockBox box = PartitionBlocks(grid, piece, pieces);
            if (box.IsEmpty())
            {
              continue;
            }
            const VertexBox vertices = box.GetGhostedVertices(grid, stored.Level);
            std::vector<std::int16_t> samples(
              static_cast<std::size_t>(vertices.GetNumberOfVertices()), 12345);
            QueryStatistics statistics;
            const auto blocks = FindBlocks(*volume, box, level);
            const Status status =
              AssembleBlocks(*volume, 0, 0, level, box, blocks, 2, samples.data(), 1, statistics);
            ASSERT_TRUE(status.IsOk()) << status.GetMessage();
            EXPECT_EQ(statistics.BlocksRead + statistics.BlockCacheHits, blocks.size());
            auto read = samples.begin();
            std::size_t wrong = 0;
            VisitVertices(vertices,
              [&](const Index3& at)
              { wrong += *read++ != source.At(at[0] << level, at[1] << level, at[2] << level); });
            EXPECT_EQ(wrong, 0u);
            const Index3 own = box.GetVertices(grid, stored.Level).GetSize();
            cells += (own[0] - 1) * (own[1] - 1) * (own[2] - 1);
          }
          const Index3 vertices = MakeGeometry(size).Coarsen(level).GetDimensions();
          EXPECT_EQ(cells, (vertices[0] - 1) * (vertices[1] - 1) * (vertices[2] - 1));
        }
      }
    }
  }
}

TEST(BlockAssembly, ReportsTheErrorOfABlock)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, MakeVolume<std::uint8_t>({ 40, 40, 40 }), MakeSettings(16, 1));
  disk.GetFile(GetStoreFolder(disk, VolumePath, "000001", 0) + "/blocks")[100] ^= 1;
  const auto volume = OpenVolume(disk);
  const BlockBox box = PartitionBlocks(volume->GetBlockGrid(), 0, 1);
  std::vector<std::uint8_t> samples(static_cast<std::size_t>(
    box.GetGhostedVertices(volume->GetBlockGrid(), 0).GetNumberOfVertices()));
  QueryStatistics statistics;
  const Status status = AssembleBlocks(
    *volume, 0, 0, 0, box, FindBlocks(*volume, box), 2, samples.data(), 1, statistics);
  ExpectError(status, StatusCode::Corrupt, "blocks");
}

TEST(BlockAssembly, StopsOnRequest)
{
  MemoryDisk disk;
  const auto volume =
    WriteAndOpen(disk, MakeVolume<std::uint8_t>({ 40, 40, 40 }), MakeSettings(16, 1));
  const BlockBox box = PartitionBlocks(volume->GetBlockGrid(), 0, 1);
  std::vector<std::uint8_t> samples(40 * 40 * 40);
  QueryStatistics statistics;
  const Status status = AssembleBlocks(*volume, 0, 0, 0, box, FindBlocks(*volume, box), 1,
    samples.data(), 1, statistics, [](double) { return false; });
  EXPECT_EQ(status.GetCode(), StatusCode::Aborted);
}

TEST(BlockAssembly, LevelWithinALimitIsTheFinestThatFits)
{
  MemoryDisk disk;
  const auto volume =
    WriteAndOpen(disk, MakeVolume<std::int16_t>({ 70, 33, 50 }), MakeSettings(16, 3));
  for (const int pieces : { 1, 2, 3, 4, 7, 20 })
  {
    std::vector<std::uint64_t> bytes; // of the largest piece, by level
    for (int level = 0; level < volume->GetNumberOfLevels(); ++level)
    {
      const StoredLevel stored = volume->FindLevel(level);
      std::int64_t layers = 0; // of blocks
      for (int piece = 0; piece < pieces; ++piece)
      {
        const BlockBox box = PartitionBlocks(*stored.Grid, piece, pieces);
        layers = std::max(layers, box.High[0] - box.Low[0]);
      }
      const double share = static_cast<double>(layers) /
        static_cast<double>(stored.Grid->GetNumberOfBlocksPerAxis()[0]);
      bytes.push_back(static_cast<std::uint64_t>(
        std::ceil(share * static_cast<double>(volume->EstimateBytes(0, level)))));
    }
    for (const std::uint64_t limit : bytes)
    {
      for (const std::uint64_t most : { limit, limit - 1 })
      {
        const auto fits = std::find_if(
          bytes.begin(), bytes.end(), [most](std::uint64_t needed) { return needed <= most; });
        const std::optional<int> level = fits == bytes.end()
          ? std::nullopt
          : std::optional<int>(static_cast<int>(fits - bytes.begin()));
        EXPECT_EQ(FindLevelWithin(*volume, { 0 }, pieces, most), level) << pieces;
        // Two arrays take twice as much.
        EXPECT_EQ(FindLevelWithin(*volume, { 0, 0 }, pieces, 2 * most), level) << pieces;
      }
    }
  }
  EXPECT_EQ(FindLevelWithin(*volume, { 0 }, 1, 0), std::nullopt);
  EXPECT_EQ(FindLevelWithin(*volume, {}, 1, 0), 0) << "no array takes no memory";
}
