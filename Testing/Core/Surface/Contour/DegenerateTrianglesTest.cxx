// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/TriangleSet.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

namespace isosurface
{
namespace
{

ContourRequest MakeRequest(std::vector<double> isovalues)
{
  ContourRequest request;
  request.Isovalues = std::move(isovalues);
  request.Normals = true;
  request.GlobalIds = true;
  request.DropDegenerateTriangles = true;
  return request;
}

template <typename T>
Surface Extract(
  const SampleVolume<T>& volume, int blockSize, const ContourRequest& request, int threads = 1)
{
  TestBlockSource<T> source(volume, blockSize);
  Result<Surface> surface = ExtractSurface(volume.Geometry, source, request, threads);
  EXPECT_TRUE(surface.IsOk()) << surface.GetStatus().GetMessage();
  return std::move(*surface);
}

/// Checks that all points are different, each has a triangle, and the parts are in order.
void CheckPoints(const Surface& surface)
{
  std::size_t points = 0;
  std::size_t cells = 0;
  for (const SurfacePart& part : surface.Parts)
  {
    EXPECT_EQ(part.FirstPoint, points);
    EXPECT_EQ(part.FirstCell, cells);
    points += part.NumberOfPoints;
    cells += part.NumberOfCells;
    std::set<Place> places;
    for (std::size_t point = part.FirstPoint; point < points; ++point)
    {
      const float* place = &surface.Points[3 * point];
      places.insert({ place[0], place[1], place[2] });
    }
    EXPECT_EQ(places.size(), part.NumberOfPoints);
  }
  EXPECT_EQ(points, surface.NumberOfPoints);
  EXPECT_EQ(cells, surface.NumberOfCells);
  std::vector<bool> used(surface.NumberOfPoints, false);
  for (std::size_t n = 0; n < surface.Connectivity.GetSize(); ++n)
  {
    used[static_cast<std::size_t>(surface.Connectivity[n])] = true;
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
}

template <typename T>
void CheckAgainstOracle(const SampleVolume<T>& volume, int blockSize,
  const std::vector<double>& isovalues, int threads = 1)
{
  const Surface surface = Extract(volume, blockSize, MakeRequest(isovalues), threads);
  CheckPoints(surface);
  const PlainSurface plain = MakePlain(surface);
  EXPECT_EQ(plain.Points.size(), surface.NumberOfPoints) << "an id is there twice";
  EXPECT_EQ(
    MakeTriangleSet(plain), DropDegenerate(MakeTriangleSet(ContourPlainly(volume, isovalues))));
}

/// Integers that change slowly, so that the samples equal to an isovalue form patches.
template <typename T>
SampleVolume<T> MakeTerraces(const Index3& dimensions, double steps)
{
  SampleVolume<T> volume(dimensions);
  for (std::int64_t k = 0; k < dimensions[2]; ++k)
  {
    for (std::int64_t j = 0; j < dimensions[1]; ++j)
    {
      for (std::int64_t i = 0; i < dimensions[0]; ++i)
      {
        const double x = double(i) / double(dimensions[0] - 1) - 0.5;
        const double y = double(j) / double(dimensions[1] - 1) - 0.5;
        const double z = double(k) / double(dimensions[2] - 1) - 0.5;
        const double radius = std::sqrt(x * x + y * y + z * z);
        volume.At(i, j, k) = static_cast<T>(std::round(steps * std::max(0.0, 1.0 - 2 * radius)));
      }
    }
  }
  return volume;
}

template <typename T>
class DegenerateTrianglesOfType : public testing::Test
{
};
using SomeTypes = testing::Types<std::uint8_t, std::int16_t, std::int64_t, float, double>;
TYPED_TEST_SUITE(DegenerateTrianglesOfType, SomeTypes);

} // namespace

TYPED_TEST(DegenerateTrianglesOfType, RandomGridsHaveTheOraclesOtherTriangles)
{
  std::mt19937 random(50);
  std::uniform_int_distribution<int> size(2, 9);
  for (int trial = 0; trial < 200; ++trial)
  {
    SampleVolume<TypeParam> volume({ size(random), size(random), size(random) });
    for (TypeParam& sample : volume.Samples)
    {
      sample = static_cast<TypeParam>(random() % 5);
    }
    CheckAgainstOracle(volume, 1 + static_cast<int>(random() % 5),
      trial % 2 == 0 ? std::vector<double>{ 2.0 } : std::vector<double>{ 1.0, 2.5, 3.0, 1.0 });
  }
}

TEST(DegenerateTriangles, BlocksOfAllSizesHaveTheOraclesOtherTriangles)
{
  std::mt19937 random(51);
  for (const Index3& dimensions : { Index3{ 70, 5, 34 }, Index3{ 4, 67, 3 }, Index3{ 3, 4, 66 } })
  {
    const auto volume = MakeRandomVolume<std::uint16_t>(random, dimensions, 6);
    for (const int blockSize : { 16, 32, 64 })
    {
      CheckAgainstOracle(volume, blockSize, { 3.0, 4.0 }, 2);
    }
  }
}

TEST(DegenerateTriangles, PointsThatRoundToAVertexAreMerged)
{
  // The crossing is so near to the vertex that its coordinate, as a float, is that of the vertex;
  // another edge of the vertex has its point well inside.
  SampleVolume<float> volume({ 3, 3, 3 });
  volume.Geometry.Extent = { 1000, 1002, 1000, 1002, 1000, 1002 };
  std::fill(volume.Samples.begin(), volume.Samples.end(), -1e6f);
  volume.At(1, 1, 1) = 1.0f;
  volume.At(2, 1, 1) = -1.0f;
  CheckAgainstOracle(volume, 1, { 0.0 });
  const Surface surface = Extract(volume, 2, MakeRequest({ 0.0 }));
  std::set<std::int64_t> ids(surface.GlobalIds.begin(), surface.GlobalIds.end());
  EXPECT_EQ(ids.size(), surface.NumberOfPoints);
}

TEST(DegenerateTriangles, TheSurfaceOfIntegersAtAnIntegerIsovalueIsAClosedManifold)
{
  const auto volume = MakeTerraces<std::uint8_t>({ 45, 41, 38 }, 20.0);
  for (const double isovalue : { 1.0, 5.0, 13.0, 19.0 })
  {
    const Surface surface = Extract(volume, 16, MakeRequest({ isovalue }), 2);
    ASSERT_GT(surface.NumberOfTriangles, 0u);
    CheckPoints(surface);
    EXPECT_TRUE(IsManifold(MakePlain(surface))) << isovalue;
    ContourRequest all = MakeRequest({ isovalue });
    all.DropDegenerateTriangles = false;
    EXPECT_LT(surface.NumberOfTriangles, Extract(volume, 16, all).NumberOfTriangles);
  }
}

TEST(DegenerateTriangles, TheSurfaceOfNoiseStaysClosed)
{
  std::mt19937 random(52);
  auto volume = MakeRandomVolume<std::uint8_t>(random, { 36, 20, 19 }, 3);
  const Index3 size = volume.GetDimensions();
  for (std::int64_t n = 0; n < size[0] * size[1] * size[2]; ++n)
  {
    const Index3 v{ n % size[0], n / size[0] % size[1], n / (size[0] * size[1]) };
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      if (v[axis] == 0 || v[axis] == size[axis] - 1)
      {
        volume.At(v[0], v[1], v[2]) = 0;
      }
    }
  }
  EXPECT_TRUE(IsClosed(MakePlain(Extract(volume, 16, MakeRequest({ 2.0 })))));
}

TEST(DegenerateTriangles, UnionOfRanksEqualsOneRank)
{
  std::mt19937 random(53);
  for (int trial = 0; trial < 100; ++trial)
  {
    const auto volume = MakeRandomVolume<std::uint8_t>(random, { 9, 8, 7 }, 4);
    const int blockSize = 1 + trial % 4;
    const TestBlockSource<std::uint8_t> all(volume, blockSize);
    std::vector<std::vector<std::int64_t>> pieces(static_cast<std::size_t>(2 + trial % 3));
    for (const std::int64_t block : all.Blocks)
    {
      pieces[random() % pieces.size()].push_back(block);
    }
    std::vector<PlainSurface> ranks;
    for (const auto& piece : pieces)
    {
      TestBlockSource<std::uint8_t> source(volume, blockSize);
      source.Blocks = piece;
      const Result<Surface> surface =
        ExtractSurface(volume.Geometry, source, MakeRequest({ 2.0, 3.0 }), 2);
      ASSERT_TRUE(surface.IsOk());
      CheckPoints(*surface);
      ranks.push_back(MakePlain(*surface));
    }
    bool agree = true;
    const PlainSurface united = UniteRanks(ranks, agree);
    EXPECT_TRUE(agree) << "two ranks disagree on a point";
    EXPECT_TRUE(united == MakePlain(Extract(volume, blockSize, MakeRequest({ 2.0, 3.0 }))));
  }
}

TEST(DegenerateTriangles, TheResultDoesNotDependOnThreads)
{
  std::mt19937 random(54);
  const auto volume = MakeRandomVolume<std::int16_t>(random, { 50, 40, 35 }, 8);
  const Surface one = Extract(volume, 16, MakeRequest({ 1.0, 2.0 }), 1);
  for (const int threads : { 2, 5 })
  {
    const Surface many = Extract(volume, 16, MakeRequest({ 1.0, 2.0 }), threads);
    ASSERT_EQ(one.NumberOfPoints, many.NumberOfPoints);
    ASSERT_EQ(one.NumberOfCells, many.NumberOfCells);
    EXPECT_TRUE(std::equal(one.GlobalIds.begin(), one.GlobalIds.end(), many.GlobalIds.begin()));
    EXPECT_TRUE(std::equal(one.Connectivity.Values32.begin(), one.Connectivity.Values32.end(),
      many.Connectivity.Values32.begin()));
    EXPECT_EQ(std::memcmp(one.Normals.GetData(), many.Normals.GetData(),
                one.Normals.GetSize() * sizeof(float)),
      0);
  }
}

TEST(DegenerateTriangles, AMergedPointHasTheNormalAndAttributesOfItsVertex)
{
  // A plane through vertices.
  SampleVolume<std::int32_t> volume({ 20, 5, 6 });
  std::vector<double> field;
  for (std::size_t n = 0; n < volume.Samples.size(); ++n)
  {
    volume.Samples[n] = static_cast<std::int32_t>(n % 20) * 10 - 90;
    field.push_back(0.1 * static_cast<double>(n));
  }
  struct Source : TestBlockSource<std::int32_t>
  {
    using TestBlockSource<std::int32_t>::TestBlockSource;
    AttributeView Attribute;
    Result<BlockSamples> Acquire(std::size_t block) override
    {
      Result<BlockSamples> samples = TestBlockSource<std::int32_t>::Acquire(block);
      samples->Attributes = { this->Attribute };
      return samples;
    }
  };
  Source source(volume, 4);
  SampleView view = volume.GetView();
  view.Type = ValueType::Float64;
  view.First = field.data();
  source.Attribute.Components = { view };
  ContourRequest request = MakeRequest({ 0.0 });
  request.Attributes = { { ValueType::Float64, 1 } };
  const Result<Surface> surface = ExtractSurface(volume.Geometry, source, request, 1);
  ASSERT_TRUE(surface.IsOk());
  ASSERT_EQ(surface->NumberOfPoints, 30u);
  const auto* values = reinterpret_cast<const double*>(surface->Attributes[0].Bytes.GetData());
  for (std::size_t point = 0; point < 30; ++point)
  {
    const float* place = &surface->Points[3 * point];
    EXPECT_EQ(place[0], 9.0f);
    const auto vertex = static_cast<std::size_t>(9 + 20 * place[1] + 100 * place[2]);
    EXPECT_EQ(values[point], field[vertex]);
    EXPECT_EQ(surface->Normals[3 * point], -1.0f);
    EXPECT_EQ(surface->GlobalIds[point], static_cast<std::int64_t>(3 * 600 + vertex));
  }
}

} // namespace isosurface
