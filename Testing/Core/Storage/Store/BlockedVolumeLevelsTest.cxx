// SPDX-License-Identifier: BSD-3-Clause
// Levels down to a single block: the cost of reading them, and their surfaces, block by block,
// against the same surface of the whole volume, subsampled in memory.
#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/PlainContour.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Storage/Spectrum/BlockWorkload.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Storage/Writing/OverviewSamples.h"

using namespace isosurface;

namespace
{

/// The vertices of a level, in a world of their own: the plain contour knows no spacing's normals.
GridGeometry MakeLevelGeometry(const Index3& size, int level)
{
  GridGeometry geometry;
  geometry.Extent = MakeGeometry(size).Coarsen(level).Extent;
  geometry.Origin = { 0.25, -3, 1000 };
  return geometry;
}

/// Every 2^level-th vertex of a volume, as a volume of its own.
template <typename T>
SampleVolume<T> Subsample(const SampleVolume<T>& volume, int level)
{
  const GridGeometry geometry = MakeLevelGeometry(volume.GetDimensions(), level);
  SampleVolume<T> coarse(geometry.GetDimensions(),
    [&](auto i, auto j, auto k) { return volume.At(i << level, j << level, k << level); });
  coarse.Geometry = geometry;
  return coarse;
}

/// The surface of all ranks at a level.
PlainSurface ContourLevel(
  BlockedVolume& opened, const std::vector<double>& isovalues, int level, int ranks)
{
  std::vector<PlainSurface> surfaces;
  for (int rank = 0; rank < ranks; ++rank)
  {
    QueryStatistics statistics;
    auto active = FindActiveBlocks(opened, { { 0, 0, isovalues }, rank, ranks }, statistics, level);
    StoredBlockSource source(opened, 0, 0, level, Require(std::move(active)));
    surfaces.push_back(MakePlain(
      Require(ExtractSurface(MakeLevelGeometry(opened.GetHeader().Grid.GetDimensions(), level),
        source, MakePlainRequest(isovalues), 2))));
  }
  return UniteRanks(surfaces);
}

} // namespace

TEST(BlockedVolumeLevels, GoDownToASingleBlock)
{
  MemoryDisk disk;
  const auto opened =
    WriteAndOpen(disk, MakeVolume<std::uint8_t>({ 300, 70, 20 }), MakeSettings(16, 3), 2);
  // 19 x 5 x 2 blocks, 5 x 2 x 1, 2 x 1 x 1, one.
  const BlockedVolumeHeader& header = opened->GetHeader();
  ASSERT_EQ(header.Overviews.size(), 3u);
  EXPECT_EQ(opened->GetNumberOfLevels(), 2 + 2 + 2 + 5);
  const std::int64_t blocks[] = { 19 * 5 * 2, 5 * 2, 2, 1 };
  for (int level = 0; level < opened->GetNumberOfLevels(); ++level)
  {
    const StoredLevel stored = opened->FindLevel(level);
    EXPECT_EQ(stored.Overview, static_cast<std::uint32_t>(std::min(level / 2, 3)));
    EXPECT_EQ(stored.Level, level - 2 * static_cast<int>(stored.Overview));
    EXPECT_EQ(stored.Grid->GetNumberOfBlocks(), blocks[stored.Overview]);
    EXPECT_EQ(opened->GetSpectrumLevel(level), level - stored.Level);
  }
  // Few blocks are not spread over many stores; nothing temporary is left.
  EXPECT_EQ(header.Overviews[0].NumberOfStores, 1u);
  for (const auto& file : disk.GetFiles())
  {
    EXPECT_EQ(file.first.find(".tmp"), std::string::npos) << file.first;
  }
  const auto single =
    WriteAndOpen(disk, MakeVolume<std::uint8_t>({ 17, 17, 1 }), MakeSettings(16, 3), 2);
  EXPECT_TRUE(single->GetHeader().Overviews.empty());
  EXPECT_EQ(single->GetNumberOfLevels(), 5);
}

TEST(BlockedVolumeLevels, HaveTheSurfaceOfTheSubsampledVolumeWithoutSeams)
{
  const Index3 sizes[] = { { 70, 67, 83 }, { 131, 34, 2 }, { 65, 129, 33 }, { 18, 3, 150 } };
  for (const Index3& size : sizes)
  {
    for (const int blockSize : { 16, 32 })
    {
      const auto volume = MakeVolume<std::int16_t>(size);
      MemoryDisk disk;
      const auto opened =
        WriteAndOpen(disk, volume, MakeSettings(blockSize, 5, DistributionMethod::Random), 3);
      for (int level = 0; level < opened->GetNumberOfLevels(); ++level)
      {
        const PlainSurface expected = ContourPlainly(Subsample(volume, level), { 49.5, 20 });
        for (const int ranks : { 1, 3 })
        {
          SCOPED_TRACE("level " + std::to_string(level) + " of " + std::to_string(size[0]) + ", " +
            std::to_string(ranks) + " ranks");
          const PlainSurface found = ContourLevel(*opened, { 49.5, 20 }, level, ranks);
          EXPECT_TRUE(found.Triangles == expected.Triangles);
          EXPECT_TRUE(found.Points == expected.Points);
          EXPECT_TRUE(level > 1 || size[2] == 2 || !found.Triangles.empty());
        }
      }
    }
  }
}

TEST(BlockedVolumeLevels, HaveTheActiveBlocksAndTrianglesOfTheSubsampledVolume)
{
  const auto volume = MakeVolume<std::uint8_t>({ 150, 61, 90 });
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, volume, MakeSettings(16, 3), 2);
  double finer = 1e300;
  for (int level = 0; level < opened->GetNumberOfLevels(); ++level)
  {
    const auto guess = Require(opened->EstimateTriangles(0, 0, 50, level));
    EXPECT_LE(guess, finer);
    finer = guess;
    if (opened->GetSpectrumLevel(level) != level)
    {
      continue;
    }
    const auto coarse = Subsample(volume, level);
    const auto spectrum = Require(opened->GetSpectrum(0, 0, level));
    BlockWorkload whole(spectrum->Bins);
    whole.Count(coarse.GetView());
    WorkloadSpectrum expected(spectrum->Bins);
    whole.MoveTo(expected);
    EXPECT_EQ(spectrum->Bins, (*opened->GetSpectrum(0, 0))->Bins);
    EXPECT_EQ(spectrum->Triangles, expected.Triangles);
    EXPECT_EQ(spectrum->ActiveCells, expected.ActiveCells);
    EXPECT_EQ(guess, static_cast<double>(expected.Triangles[expected.FindBin(50)]));

    QueryStatistics statistics;
    const auto active = Require(FindActiveBlocks(*opened, { { 0, 0, { 50 } } }, statistics, level));
    EXPECT_EQ(
      SortBlocks(active), FindBlocksByForce(coarse, *opened->FindLevel(level).Grid, { 50 }));
  }
  EXPECT_FALSE(opened->EstimateTriangles(0, 0, 50, opened->GetNumberOfLevels()).IsOk());
  EXPECT_FALSE(opened->EstimateTriangles(0, 0, 50, -1).IsOk());
}

TEST(BlockedVolumeLevels, CostRequestsAndBytesInProportion)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, MakeVolume<std::uint16_t>({ 257, 257, 257 }), MakeSettings(32, 2));
  const auto opened = OpenVolume(disk, 0);
  for (int level = 0; level < 5; ++level)
  {
    QueryStatistics statistics;
    const auto blocks = Require(opened->ListBlocks(0, statistics, level));
    for (const BlockReference& block : blocks)
    {
      ASSERT_TRUE(opened->ReadBlock(block, 0, 0, level, statistics).IsOk());
    }
    // With ghost layers a level of 33^3 samples stores 35^3 of them, one of 17^3 in a record 19^3.
    const double samples = std::pow(257 >> level, 3);
    EXPECT_LT(static_cast<double>(statistics.BytesRead), 1.75 * 2 * samples) << level;
    EXPECT_EQ(statistics.BlocksRead, level < 2 ? 512u : level < 4 ? 8u : 1u);
  }
}

TEST(BlockedVolumeLevels, AreRefusedForBlocksOfOtherLevels)
{
  MemoryDisk disk;
  const auto opened =
    WriteAndOpen(disk, MakeVolume<std::uint8_t>({ 70, 70, 70 }), MakeSettings(16, 2));
  QueryStatistics statistics;
  const auto fine = opened->ListBlocks(0, statistics, 1);
  const auto coarse = opened->ListBlocks(0, statistics, 2);
  ASSERT_TRUE(fine.IsOk() && coarse.IsOk());
  EXPECT_TRUE(opened->ReadBlock((*fine)[0], 0, 0, 0, statistics).IsOk());
  EXPECT_TRUE(opened->ReadBlock((*coarse)[0], 0, 0, 3, statistics).IsOk());
  for (const auto& [block, level] : { std::make_pair((*fine)[0], 2), { (*coarse)[0], 1 },
         { (*fine)[0], -1 }, { (*coarse)[0], 99 } })
  {
    EXPECT_EQ(opened->ReadBlock(block, 0, 0, level, statistics).GetStatus().GetCode(),
      StatusCode::InvalidArgument);
  }
  EXPECT_FALSE(opened->ListBlocks(0, statistics, 99).IsOk());
  EXPECT_FALSE(FindActiveBlocks(*opened, { { 0, 0, { 50 } } }, statistics, -1).IsOk());
  EXPECT_FALSE(opened->GetSpectrum(0, 0, 99).IsOk());
}

TEST(OverviewSource, ReadsTheSamplesOfTheVolumeInEveryBox)
{
  // Two arrays in parts of blocks of five stores.
  const BlockGrid finer({ 70, 35, 50 }, 16, 2);
  const auto value = [](std::int64_t i, std::int64_t j, std::int64_t k)
  { return i + 100 * (j + 100 * k); };
  std::vector<std::uint32_t> stores;
  std::vector<std::unique_ptr<WritableFile>> files;
  MemoryDisk disk;
  ASSERT_TRUE(disk.MakeDirectories("/data").IsOk());
  for (std::size_t store = 0; store < 5; ++store)
  {
    files.push_back(std::move(*disk.CreateForWriting(OverviewSource::GetPath("/data", store))));
  }
  for (std::int64_t block = 0; block < finer.GetNumberOfBlocks(); ++block)
  {
    stores.push_back(static_cast<std::uint32_t>(block * 7 % 5));
    const VertexBox part = FindOverviewPart(finer, block);
    std::vector<std::uint8_t> bytes;
    std::vector<std::uint8_t> others;
    VisitVertices(part,
      [&](const Index3& vertex)
      {
        const auto [i, j, k] = vertex;
        bytes.push_back(static_cast<std::uint8_t>(value(i, j, k)));
        const auto real = static_cast<double>(value(i, j, k));
        const auto* raw = reinterpret_cast<const std::uint8_t*>(&real);
        others.insert(others.end(), raw, raw + sizeof(real));
      });
    bytes.insert(bytes.end(), others.begin(), others.end());
    ASSERT_TRUE(files[stores.back()]->Append(bytes.data(), bytes.size()).IsOk());
  }
  for (const auto& file : files)
  {
    ASSERT_TRUE(file->SyncAndClose().IsOk());
  }
  OverviewSource source(disk, "/data", finer, { ValueType::UInt8, ValueType::Float64 }, stores, 5);
  EXPECT_EQ(source.GetBox(), (VertexBox{ { 0, 0, 0 }, { 18, 9, 13 } }));
  std::mt19937 random(2);
  for (int trial = 0; trial < 100; ++trial)
  {
    VertexBox box = source.GetBox();
    for (std::size_t axis = 0; axis < 3 && trial > 0; ++axis)
    {
      const auto size = static_cast<std::uint32_t>(source.GetBox().High[axis]);
      box.Low[axis] = random() % size;
      box.High[axis] = box.Low[axis] + 1 + random() % (size - box.Low[axis]);
    }
    const auto slab = Require(source.Read(box));
    ASSERT_TRUE(slab.Fits({ ValueType::UInt8, ValueType::Float64 }, box));
    EXPECT_GE(source.GetReadBytes(box), static_cast<std::uint64_t>(9 * box.GetNumberOfVertices()));
    std::size_t wrong = 0;
    VisitVertices(box,
      [&](const Index3& vertex)
      {
        const std::int64_t expected = value(vertex[0], vertex[1], vertex[2]);
        wrong += *slab.Arrays[0].At<std::uint8_t>(vertex) != static_cast<std::uint8_t>(expected);
        wrong += *slab.Arrays[1].At<double>(vertex) != static_cast<double>(expected);
      });
    EXPECT_EQ(wrong, 0u);
  }
  disk.GetFile(OverviewSource::GetPath("/data", 1)).pop_back();
  EXPECT_EQ(source.Read(source.GetBox()).GetStatus().GetCode(), StatusCode::Corrupt);
}
