// SPDX-License-Identifier: BSD-3-Clause
// Which part of a volume is shown exactly where a person looks.
#include "Ranks/Query/SightedBox.h"

#include "Ground/Volume/VertexPlaces.h"

#include <gtest/gtest.h>

using namespace isosurface;

namespace
{

const Index3 SightChunk = { 8, 16, 20 };

/// A volume of 201 x 181 x 161 vertices, turned about z by a quarter.
BlockedVolumeHeader MakeSightedVolume()
{
  BlockedVolumeHeader volume;
  volume.Grid.Extent = { 5, 205, 0, 180, 0, 160 };
  volume.Grid.Origin = { 10, 20, 30 };
  volume.Grid.Spacing = { 0.5, 1, 2 };
  volume.Grid.Direction = { 0, -1, 0, 1, 0, 0, 0, 0, 1 };
  volume.TimeSteps.emplace_back();
  volume.TimeSteps.back().Source = SourceRecord();
  volume.TimeSteps.back().Source->Chunk = SightChunk;
  return volume;
}

/// A sample of every `step`-th vertex from a vertex on.
GridGeometry MakeSightedSample(const GridGeometry& grid, const Index3& first, const Index3& step)
{
  GridGeometry sample = grid;
  const auto origin = VertexPlaces(grid).FindPoint({ static_cast<double>(first[0]),
    static_cast<double>(first[1]), static_cast<double>(first[2]) });
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    sample.Origin[axis] = origin[axis];
    sample.Spacing[axis] *= static_cast<double>(step[axis]);
    sample.Extent[2 * axis] = 0;
    sample.Extent[2 * axis + 1] = (grid.GetDimensions()[axis] - 1 - first[axis]) / step[axis];
  }
  return sample;
}

Sight LookFromAbove(const GridGeometry& grid, const std::array<double, 3>& vertex, double radius)
{
  Sight sight;
  sight.Eye = VertexPlaces(grid).FindPoint(vertex);
  sight.Eye[2] += 100;
  sight.Radius = radius - 100 * 0.01;
  sight.Widening = 0.01;
  return sight;
}

} // namespace

TEST(SightedBox, HasWholeChunksAroundThePointAndAsManyVerticesAsMayBe)
{
  const BlockedVolumeHeader volume = MakeSightedVolume();
  const GridGeometry sample = MakeSightedSample(volume.Grid, { 0, 0, 0 }, { 1, 1, 1 });
  const Sight sight = LookFromAbove(volume.Grid, { 100, 90, 80 }, 20);
  const SightedBox wide = FindSightedBox(volume, sight, 100, {}, 1 << 30, sample, nullptr);
  EXPECT_EQ(wide.Exact, (VertexBox{ { 56, 64, 60 }, { 144, 112, 100 } }))
    << "40, 20 and 10 vertices each way";
  EXPECT_EQ(wide.Exact, wide.Sampled);
  const SightedBox small = FindSightedBox(volume, sight, 100, {}, 30'000, sample, nullptr);
  EXPECT_LE(small.Exact.GetNumberOfVertices(), 30'000);
  EXPECT_GT(small.Exact.GetNumberOfVertices(), 8'000);
  EXPECT_TRUE(wide.Exact.Contains(small.Exact));
  EXPECT_TRUE(small.Exact.Contains({ { 100, 90, 80 }, { 101, 91, 81 } }));
  EXPECT_TRUE(FindSightedBox(volume, sight, 100, {}, 2'000, sample, nullptr).Exact.IsEmpty())
    << "a chunk has more";
}

TEST(SightedBox, HasItsFacesWhereTheSampleHasVertices)
{
  const BlockedVolumeHeader volume = MakeSightedVolume();
  const GridGeometry sample = MakeSightedSample(volume.Grid, { 3, 3, 3 }, { 7, 5, 9 });
  const SightedBox box = FindSightedBox(
    volume, LookFromAbove(volume.Grid, { 100, 90, 80 }, 20), 100, {}, 1 << 30, sample, nullptr);
  EXPECT_EQ(box.Exact, (VertexBox{ { 59, 68, 66 }, { 144, 109, 94 } }));
  EXPECT_EQ(box.Sampled, (VertexBox{ { 8, 13, 7 }, { 21, 22, 11 } }));
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t step = Index3{ 7, 5, 9 }[axis];
    EXPECT_EQ(3 + step * box.Sampled.Low[axis], box.Exact.Low[axis]);
    EXPECT_EQ(3 + step * (box.Sampled.High[axis] - 1), box.Exact.High[axis] - 1);
  }
}

TEST(SightedBox, BeyondTheSampleTakesTheVolumeAlone)
{
  const BlockedVolumeHeader volume = MakeSightedVolume();
  const GridGeometry sample = MakeSightedSample(volume.Grid, { 150, 0, 0 }, { 7, 5, 9 });
  const SightedBox beside = FindSightedBox(
    volume, LookFromAbove(volume.Grid, { 50, 90, 80 }, 20), 100, {}, 1 << 30, sample, nullptr);
  EXPECT_EQ(beside.Exact, (VertexBox{ { 8, 64, 60 }, { 96, 112, 100 } }));
  EXPECT_TRUE(beside.Sampled.IsEmpty());
  const SightedBox around = FindSightedBox(
    volume, LookFromAbove(volume.Grid, { 150, 90, 80 }, 20), 100, {}, 1 << 30, sample, nullptr);
  EXPECT_EQ(around.Exact.Low[0], 104) << "the sample begins in the box";
  EXPECT_EQ(around.Sampled.Low[0], 0);
  EXPECT_EQ(around.Exact.High[0] - 1, 150 + 7 * (around.Sampled.High[0] - 1));
}

TEST(SightedBox, KeepsWithinTheVolumeAndARegion)
{
  const BlockedVolumeHeader volume = MakeSightedVolume();
  const GridGeometry sample = MakeSightedSample(volume.Grid, { 0, 0, 0 }, { 1, 1, 1 });
  const Sight past = LookFromAbove(volume.Grid, { 300, 90, 80 }, 20);
  const VertexBox atEnd = FindSightedBox(volume, past, 100, {}, 1 << 30, sample, nullptr).Exact;
  EXPECT_EQ(atEnd.High[0], 201);
  EXPECT_EQ(atEnd.Low[0], 160);
  const Sight sight = LookFromAbove(volume.Grid, { 100, 90, 80 }, 20);
  const auto height = [](double vertex) { return 30 + 2 * vertex; };
  const Region region = Region::FromBounds({ -1e6, 1e6, -1e6, 1e6, height(0), height(79) });
  const VertexBox cut = FindSightedBox(volume, sight, 100, region, 1 << 30, sample, nullptr).Exact;
  EXPECT_EQ(cut, (VertexBox{ { 56, 64, 60 }, { 144, 112, 80 } }));
}
