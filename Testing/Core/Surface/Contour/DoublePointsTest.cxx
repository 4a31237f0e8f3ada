// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/CodedVolumes.h"
#include "Fixtures/PlainContour.h"
#include "Surface/Contour/SurfaceMerge.h"
#include "Surface/Contour/TriangleNormals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <vector>

using namespace isosurface;

namespace
{

// A ball of radius 5 in the middle, at map coordinates, in samples of 5 cm.
SampleVolume<float> MakeBallOnMap()
{
  SampleVolume<float> volume({ 17, 17, 17 },
    [](auto i, auto j, auto k)
    {
      return 5 -
        std::hypot(
          static_cast<double>(i) - 8, static_cast<double>(j) - 8, static_cast<double>(k) - 8);
    });
  volume.Geometry.Origin = { 448000, 6000000, -2000 };
  volume.Geometry.Spacing = { 0.05, 0.05, 0.05 };
  return volume;
}

// The place of the edge of a global id at which the samples, interpolated, have the isovalue 0.
Vector3 FindPlace(const SampleVolume<float>& volume, std::int64_t id)
{
  const GridGeometry& grid = volume.Geometry;
  const Index3 size = volume.GetDimensions();
  Index3 from{ id / 3 % size[0], id / 3 / size[0] % size[1], id / 3 / size[0] / size[1] };
  Index3 to = from;
  const auto along = static_cast<std::size_t>(id % 3);
  ++to[along];
  const double low = volume.At(from);
  const double high = volume.At(to);
  Vector3 place{};
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double t = axis == along ? -low / (high - low) : 0;
    place[axis] = grid.Origin[axis] +
      grid.Spacing[axis] * (static_cast<double>(grid.Extent[2 * axis] + from[axis]) + t);
  }
  return place;
}

void ExpectExactPlaces(const SampleVolume<float>& volume, const Surface& surface)
{
  ASSERT_TRUE(surface.HasDoublePoints);
  EXPECT_TRUE(surface.Points.IsEmpty());
  ASSERT_EQ(surface.DoublePoints.GetSize(), 3 * surface.NumberOfPoints);
  EXPECT_GT(surface.NumberOfPoints, 0U);
  for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
  {
    const Vector3 expected = FindPlace(volume, surface.GlobalIds[point]);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      ASSERT_NEAR(surface.GetPoint(point)[axis], expected[axis], 4e-9) << point;
    }
  }
}

} // namespace

TEST(DoublePoints, AreWhereTheSamplesSayAtMapCoordinates)
{
  const auto volume = MakeBallOnMap();
  for (const int threads : { 1, 3 })
  {
    ExpectExactPlaces(volume, ExtractBlocks(volume, 4, MakePlainRequest({ 0.0 }), threads));
  }
}

TEST(DoublePoints, AreThereWhereTheExtentIsFarFromZero)
{
  auto volume = MakeBallOnMap();
  volume.Geometry.Extent = { 9000000, 9000016, -8000000, -7999984, 0, 16 };
  volume.Geometry.Origin = { -450000, 400000, 0 };
  ExpectExactPlaces(volume, ExtractBlocks(volume, 4, MakePlainRequest({ 0.0 })));
}

TEST(DoublePoints, HaveTheTrianglesIdsAndNormalsOfFloatPoints)
{
  auto volume = MakeBallOnMap();
  volume.Geometry.Direction = { 0.6, 0.8, 0, 0.8, -0.6, 0, 0, 0, 1 };
  ContourRequest request = MakePlainRequest({ 0.0, 1.5 });
  const Surface fine = ExtractBlocks(volume, 4, request);
  request.Precision = PointPrecision::Single;
  const Surface coarse = ExtractBlocks(volume, 4, request);
  EXPECT_TRUE(fine.HasDoublePoints);
  EXPECT_FALSE(coarse.HasDoublePoints);
  ExpectSameTopology(coarse, fine);
  EXPECT_TRUE(HaveEqualBytes(coarse.Normals, fine.Normals));
}

TEST(DoublePoints, ArePointsWithoutRoundingWhereTheyAreAskedFor)
{
  auto volume = MakeBallOnMap();
  volume.Geometry.Origin = { 1, 2, 3 };
  ContourRequest request = MakePlainRequest({ 0.0 });
  EXPECT_FALSE(ExtractBlocks(volume, 4, request).HasDoublePoints);
  request.Precision = PointPrecision::Double;
  ExpectExactPlaces(volume, ExtractBlocks(volume, 4, request));
}

TEST(DoublePoints, OfSeveralBlocksAndRanksAreEqualWhereTheyMeet)
{
  const auto volume = MakeBallOnMap();
  const ContourRequest request = MakePlainRequest({ 0.0 });
  TestBlockSource<float> all(volume, 4, 1);
  const Surface whole = Require(ExtractSurface(volume.Geometry, all, request, 1));
  std::vector<Surface> pieces;
  for (const std::int64_t odd : { 0, 1 })
  {
    TestBlockSource<float> source(volume, 4, 1);
    source.Blocks.clear();
    for (std::int64_t block = odd; block < 64; block += 2)
    {
      source.Blocks.push_back(block);
    }
    pieces.push_back(Require(ExtractSurface(volume.Geometry, source, request, 1)));
  }
  std::map<std::int64_t, Vector3> places;
  for (const Surface* surface : std::vector<const Surface*>{ &whole, &pieces[0], &pieces[1] })
  {
    for (std::size_t point = 0; point < surface->NumberOfPoints; ++point)
    {
      const Vector3 place = surface->GetPoint(point);
      EXPECT_EQ(places.emplace(surface->GlobalIds[point], place).first->second, place);
    }
  }
  const Surface merged = MergeSurfaces(pieces);
  EXPECT_EQ(merged.NumberOfPoints, whole.NumberOfPoints);
  ExpectExactPlaces(volume, merged);
}

TEST(DoublePoints, ClosedSidesAndMergedVerticesLieOnTheGrid)
{
  auto volume = MakeBallOnMap();
  for (float& sample : volume.Samples)
  {
    sample = std::round(sample); // many samples equal the isovalue
  }
  ContourRequest request = MakePlainRequest({ 0.0 });
  request.ClosedSides = GridSides::All();
  request.DropDegenerateTriangles = true;
  const Surface fine = ExtractBlocks(volume, 4, request);
  volume.Geometry.Origin = { 0, 0, 0 };
  volume.Geometry.Spacing = { 1, 1, 1 };
  const Surface plain = ExtractBlocks(volume, 4, request);
  ExpectSameTopology(plain, fine);
  for (std::size_t point = 0; point < plain.NumberOfPoints; ++point)
  {
    const Vector3 origin{ 448000, 6000000, -2000 };
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      ASSERT_NEAR(
        fine.GetPoint(point)[axis], origin[axis] + 0.05 * plain.GetPoint(point)[axis], 1e-7);
    }
  }
}

TEST(DoublePoints, OnLinesAreWhereTheLinesSay)
{
  const auto volume = MakeBallOnMap();
  GridLines lines;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    for (int n = 0; n < 17; ++n)
    {
      lines.Coordinates[axis].push_back(volume.Geometry.Origin[axis] + 0.05 * n);
    }
  }
  SampleVolume<float> lined = volume;
  lined.Geometry.Origin = { 0, 0, 0 };
  lined.Geometry.Spacing = { 1, 1, 1 };
  ContourRequest request = MakePlainRequest({ 0.0 });
  request.Lines = &lines;
  ExpectExactPlaces(volume, ExtractBlocks(lined, 4, request));
}

TEST(DoublePoints, NextToANanAreNan)
{
  auto volume = MakeBallOnMap();
  volume.At(8, 8, 3) = std::numeric_limits<float>::quiet_NaN();
  const Surface surface = ExtractBlocks(volume, 4, MakePlainRequest({ 0.0 }));
  std::size_t wrong = 0;
  for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
  {
    const Vector3 place = surface.GetPoint(point);
    wrong += std::isnan(place[0]) && std::isnan(place[1]) && std::isnan(place[2]) ? 1U : 0U;
  }
  EXPECT_GT(wrong, 0U);
}

TEST(DoublePoints, StreamsDecodeToTheExtractedPoints)
{
  const auto volume = MakeBallOnMap();
  TestBlockSource<float> source(volume, 4, 1);
  const ContourRequest request = MakeRequest({ 0.0, 1.0 });
  const Surface extracted = Require(ExtractSurface(volume.Geometry, source, request, 1));
  const Surface decoded = EncodeAndDecode(
    MakeHeader(volume, { 0.0, 1.0 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Working), source,
    request);
  ExpectSamePoints(extracted, decoded);
  EXPECT_TRUE(decoded.HasDoublePoints);
  EXPECT_TRUE(HaveEqualBytes(extracted.DoublePoints, decoded.DoublePoints));
}

TEST(DoublePoints, GiveTheNormalsOfTheirTriangles)
{
  Surface surface = ExtractBlocks(MakeBallOnMap(), 4, MakePlainRequest({ 0.3 }));
  const Buffer<float> exact = std::move(surface.Normals);
  ComputeNormalsOfTriangles(surface);
  for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
  {
    const auto get = [point](const Buffer<float>& normals) -> Vector3 {
      return { normals[3 * point], normals[3 * point + 1], normals[3 * point + 2] };
    };
    EXPECT_GT(Dot(get(exact), get(surface.Normals)), 0.9);
  }
}
