// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/ActiveBlocks.h"
#include "Storage/Store/StoredBlockSource.h"

#include "Fixtures/BlocksByForce.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <tuple>

using namespace isosurface;

namespace
{

constexpr int SelectedBlockSize = 16;

/// The oracle. A block is in the region if one of its vertices is, which is enough for boxes larger
/// than a cell.
std::vector<std::int64_t> FindByForce(const SampleVolume<std::uint8_t>& volume,
  const std::vector<double>& isovalues, bool closed, const std::array<double, 6>* bounds)
{
  const BlockGrid grid(volume.GetDimensions(), SelectedBlockSize);
  auto blocks = FindBlocksByForce(volume, grid, isovalues, closed);
  if (!bounds)
  {
    return blocks;
  }
  const GridGeometry geometry = MakeGeometry(volume.GetDimensions());
  const auto isOutside = [&](std::int64_t block)
  {
    bool isWithin = false;
    VisitVertices(grid.GetVertices(block),
      [&](const Index3& vertex)
      {
        bool in = true;
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          const double place = geometry.Origin[axis] +
            geometry.Spacing[axis] * static_cast<double>(vertex[axis] + geometry.Extent[2 * axis]);
          in = in && place >= (*bounds)[2 * axis] && place <= (*bounds)[2 * axis + 1];
        }
        isWithin = isWithin || in;
      });
    return !isWithin;
  };
  blocks.erase(std::remove_if(blocks.begin(), blocks.end(), isOutside), blocks.end());
  return blocks;
}

/// Three arrays on one grid: density, its double, and the negative as float.
void WriteThreeArrays(FileSystem& disk, const SampleVolume<std::uint8_t>& volume)
{
  const SampleVolume<std::uint16_t> twice(volume.GetDimensions(),
    [&](auto i, auto j, auto k) { return static_cast<std::uint16_t>(2 * volume.At(i, j, k)); });
  const SampleVolume<float> negative(volume.GetDimensions(),
    [&](auto i, auto j, auto k) { return -static_cast<float>(volume.At(i, j, k)); });
  ThreadCommunicator::Run(1,
    [&](Communicator& communicator)
    {
      VolumePiece piece;
      piece.Box = { { 0, 0, 0 }, volume.GetDimensions() };
      piece.Arrays = { volume.GetView(), twice.GetView(), negative.GetView() };
      BlockedVolumeWriter writer(communicator, disk);
      const auto written = writer.Write(VolumePath, MakeGeometry(volume.GetDimensions()),
        { { "density", ValueType::UInt8 }, { "twice", ValueType::UInt16 },
          { "negative", ValueType::Float32 } },
        piece, MakeSettings(SelectedBlockSize, 2));
      ASSERT_TRUE(written.IsOk()) << written.GetStatus().GetMessage();
    });
}

} // namespace

TEST(BlockedVolumeSelection, BlocksEqualBruteForceForAnyNumberOfRanks)
{
  const auto volume = MakeVolume<std::uint8_t>({ 70, 60, 50 });
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, volume, MakeSettings(SelectedBlockSize, 3));
  const std::array<double, 6> bounds{ 0.1, 15.0, 10.0, 30.5, 12380.0, 12420.0 };
  for (const std::vector<double>& isovalues :
    { std::vector<double>{ 50.0 }, { 2.0 }, { 3.0, 90.0 }, { 0.0 }, { 200.0 }, { -1e30, 1e30 } })
  {
    for (const bool closed : { false, true })
    {
      for (const bool inRegion : { false, true })
      {
        BlockSelection selection;
        selection.ClosedSides = closed ? GridSides::All() : GridSides{};
        selection.Region = inRegion ? Region::FromBounds(bounds) : Region();
        const auto expected = FindByForce(volume, isovalues, closed, inRegion ? &bounds : nullptr);
        for (const int ranks : { 1, 2, 3, 7 })
        {
          std::vector<BlockReference> all;
          for (int rank = 0; rank < ranks; ++rank)
          {
            QueryStatistics statistics;
            const auto mine = Require(FindActiveBlocks(
              *opened, { { 0, 0, isovalues, selection }, rank, ranks }, statistics));
            EXPECT_EQ(statistics.ActiveBlocks, mine.size());
            all.insert(all.end(), mine.begin(), mine.end());
          }
          EXPECT_EQ(SortBlocks(all), expected);
        }
      }
    }
  }
}

TEST(BlockedVolumeSelection, BlocksOutsideOfTheRegionAreNotRead)
{
  const auto volume = MakeVolume<std::uint8_t>({ 70, 60, 50 });
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, volume, MakeSettings(SelectedBlockSize, 3));
  const std::array<double, 6> bounds{ 0.1, 5.0, 10.0, 20.5, 12370.0, 12400.0 };
  BlockSelection selection;
  selection.Region = Region::FromBounds(bounds);
  QueryStatistics statistics;
  auto active = Require(FindActiveBlocks(*opened, { { 0, 0, { 50.0 }, selection } }, statistics));
  StoredBlockSource source(*opened, 0, 0, 0, active);
  ContourRequest request;
  request.Isovalues = { 50.0 };
  const auto surface = Require(ExtractSurface(opened->GetHeader().Grid, source, request, 2));
  const auto inRegion = FindByForce(volume, { 50.0 }, false, &bounds).size();
  EXPECT_EQ(source.GetStatistics().BlocksRead, inRegion);
  EXPECT_LT(inRegion, FindByForce(volume, { 50.0 }, false, nullptr).size());
  EXPECT_GT(surface.NumberOfTriangles, 0u);
}

TEST(BlockedVolumeSelection, ClosedSurfaceOfAllRanksIsClosedAtEveryLevel)
{
  MemoryDisk disk;
  const auto opened = WriteAndOpen(
    disk, MakeVolume<std::uint8_t>({ 70, 52, 35 }), MakeSettings(SelectedBlockSize, 3));
  BlockSelection selection;
  selection.ClosedSides = GridSides::All();
  ContourRequest request;
  request.Isovalues = { 40.0 };
  request.GlobalIds = true;
  request.Normals = true;
  request.ClosedSides = selection.ClosedSides;
  for (const int level : { 0, 1, 3 })
  {
    std::map<std::pair<std::int64_t, std::int64_t>, int> sides;
    for (int rank = 0; rank < 3; ++rank)
    {
      QueryStatistics statistics;
      auto active = Require(FindActiveBlocks(
        *opened, { { 0, 0, request.Isovalues, selection }, rank, 3 }, statistics, level));
      StoredBlockSource source(*opened, 0, 0, level, active);
      const auto surface =
        Require(ExtractSurface(opened->GetHeader().Grid.Coarsen(level), source, request, 1));
      for (std::size_t corner = 0; corner < 3 * surface.NumberOfTriangles; ++corner)
      {
        const std::size_t next = corner % 3 == 2 ? corner - 2 : corner + 1;
        const std::int64_t from =
          surface.GlobalIds[static_cast<std::size_t>(surface.Connectivity[corner])];
        const std::int64_t to =
          surface.GlobalIds[static_cast<std::size_t>(surface.Connectivity[next])];
        sides[std::minmax(from, to)] += from < to ? 1 : -1;
      }
    }
    EXPECT_GT(sides.size(), 0u);
    EXPECT_TRUE(
      std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 0; }))
      << "level " << level;
  }
}

TEST(BlockedVolumeSelection, AdjacentArraysOfABlockAreReadByOneRead)
{
  const auto volume = MakeVolume<std::uint8_t>({ 40, 30, 20 });
  MemoryDisk disk;
  WriteThreeArrays(disk, volume);
  const auto opened = OpenVolume(disk);
  QueryStatistics statistics;
  const auto share = Require(opened->ListBlocks(0, statistics));
  std::size_t block = 0;
  for (const auto& [arrays, cached, reads] :
    { std::tuple<std::vector<std::size_t>, std::vector<std::size_t>, std::uint64_t>{
        { 0, 1, 2 }, {}, 1 },
      { { 2, 0, 1 }, {}, 2 }, { { 0, 2 }, {}, 2 }, { { 0, 1, 2 }, { 1 }, 2 },
      { { 0, 1, 2 }, { 0, 1, 2 }, 0 } })
  {
    const BlockReference& reference = share[block++];
    for (const std::size_t array : cached)
    {
      ASSERT_TRUE(opened->ReadBlock(reference, 0, array, 0, statistics).IsOk());
    }
    QueryStatistics cost;
    const std::uint64_t before = disk.GetReads();
    const auto together = Require(opened->ReadVariables(reference, 0, arrays, 0, cost));
    EXPECT_EQ(cost.BlocksRead, reads);
    EXPECT_LE(disk.GetReads() - before, reads + 1); // one page of the directory
    EXPECT_EQ(cost.BlockCacheHits, cached.size());
    const auto fresh = OpenVolume(disk);
    for (std::size_t n = 0; n < arrays.size(); ++n)
    {
      const auto alone = Require(fresh->ReadBlock(reference, 0, arrays[n], 0, statistics));
      ASSERT_EQ(alone->Bytes.GetSize(), together[n]->Bytes.GetSize());
      EXPECT_EQ(
        std::memcmp(alone->Bytes.GetData(), together[n]->Bytes.GetData(), alone->Bytes.GetSize()),
        0);
    }
  }
}

TEST(BlockedVolumeSelection, InterpolatedArraysOfTheContouredOneHaveTheIsovalue)
{
  const auto volume = MakeVolume<std::uint8_t>({ 40, 30, 20 });
  MemoryDisk disk;
  WriteThreeArrays(disk, volume);
  const auto opened = OpenVolume(disk);
  QueryStatistics statistics;
  for (const int level : { 0, 1 })
  {
    auto active = Require(FindActiveBlocks(*opened, { { 0, 0, { 30.25 } } }, statistics, level));
    StoredBlockSource source(*opened, 0, 0, level, active);
    source.SetAttributes({ 2, 1 });
    ContourRequest request;
    request.Isovalues = { 30.25 };
    request.Attributes = { { ValueType::Float32, 1 }, { ValueType::UInt16, 1 } };
    const auto surface =
      Require(ExtractSurface(opened->GetHeader().Grid.Coarsen(level), source, request, 2));
    ASSERT_GT(surface.NumberOfPoints, 0u);
    const auto* negative = reinterpret_cast<const float*>(surface.Attributes[0].Bytes.GetData());
    const auto* twice = reinterpret_cast<const float*>(surface.Attributes[1].Bytes.GetData());
    for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
    {
      ASSERT_NEAR(negative[point], -30.25f, 1e-4f);
      ASSERT_NEAR(twice[point], 60.5f, 1e-4f);
    }
    // Both further arrays follow each other, but are asked for in the other order.
    EXPECT_LE(source.GetStatistics().BlocksRead, 3 * active.size());
  }
}

TEST(BlockedVolumeSelection, MissingFurtherArrayIsAnError)
{
  const auto volume = MakeVolume<std::uint8_t>({ 40, 30, 20 });
  MemoryDisk disk;
  WriteThreeArrays(disk, volume);
  const auto opened = OpenVolume(disk);
  QueryStatistics statistics;
  const auto active = Require(FindActiveBlocks(*opened, { { 0, 0, { 30.25 } } }, statistics));
  StoredBlockSource source(*opened, 0, 0, 0, active);
  source.SetAttributes({ 5 });
  ContourRequest request;
  request.Isovalues = { 30.25 };
  request.Attributes = { { ValueType::Float32, 1 } };
  const auto surface = ExtractSurface(opened->GetHeader().Grid, source, request, 2);
  ExpectMessage(surface.GetStatus(), VolumePath);
}
