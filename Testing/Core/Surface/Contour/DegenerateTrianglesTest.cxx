// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/LongTests.h"
#include "Fixtures/TriangleSet.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

using namespace isosurface;

namespace
{

ContourRequest MakeDroppingRequest(std::vector<double> isovalues)
{
  ContourRequest request = MakePlainRequest(std::move(isovalues));
  request.DropDegenerateTriangles = true;
  return request;
}

/// Checks that all points are different, each has a triangle, and the parts are in order.
void CheckPoints(const Surface& surface)
{
  ExpectWholeParts(surface);
  for (const SurfacePart& part : surface.Parts)
  {
    std::set<Place> places;
    for (std::size_t point = 0; point < part.NumberOfPoints; ++point)
    {
      const float* place = &surface.Points[3 * (part.FirstPoint + point)];
      places.insert({ place[0], place[1], place[2] });
    }
    EXPECT_EQ(places.size(), part.NumberOfPoints);
  }
}

template <typename T>
void CheckProperTriangles(const SampleVolume<T>& volume, int blockSize,
  const std::vector<double>& isovalues, int threads = 1)
{
  const Surface surface = ExtractBlocks(volume, blockSize, MakeDroppingRequest(isovalues), threads);
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
  VisitVertices(VertexBox{ {}, dimensions },
    [&](const Index3& vertex)
    {
      const auto [i, j, k] = vertex;
      const double x = double(i) / double(dimensions[0] - 1) - 0.5;
      const double y = double(j) / double(dimensions[1] - 1) - 0.5;
      const double z = double(k) / double(dimensions[2] - 1) - 0.5;
      const double radius = std::sqrt(x * x + y * y + z * z);
      volume.At(vertex) = static_cast<T>(std::round(steps * std::max(0.0, 1.0 - 2 * radius)));
    });
  return volume;
}

template <typename T>
class DegenerateTrianglesOfType : public testing::Test
{
};
using TypesOfDegenerateTriangles =
  testing::Types<std::uint8_t, std::int16_t, std::int64_t, float, double>;
TYPED_TEST_SUITE(DegenerateTrianglesOfType, TypesOfDegenerateTriangles);

} // namespace

TYPED_TEST(DegenerateTrianglesOfType, RandomGridsHaveTheOraclesOtherTriangles)
{
  std::mt19937 random(50);
  std::uniform_int_distribution<int> size(2, 9);
  for (int trial = 0; trial < ChooseTrials(200); ++trial)
  {
    SampleVolume<TypeParam> volume({ size(random), size(random), size(random) });
    for (TypeParam& sample : volume.Samples)
    {
      sample = static_cast<TypeParam>(random() % 5);
    }
    CheckProperTriangles(volume, 1 + static_cast<int>(random() % 5),
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
      CheckProperTriangles(volume, blockSize, { 3.0, 4.0 }, 2);
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
  CheckProperTriangles(volume, 1, { 0.0 });
  const Surface surface = ExtractBlocks(volume, 2, MakeDroppingRequest({ 0.0 }));
  std::set<std::int64_t> ids(surface.GlobalIds.begin(), surface.GlobalIds.end());
  EXPECT_EQ(ids.size(), surface.NumberOfPoints);
}

TEST(DegenerateTriangles, TheSurfaceOfIntegersAtAnIntegerIsovalueIsAClosedManifold)
{
  const auto volume = MakeTerraces<std::uint8_t>({ 45, 41, 38 }, 20.0);
  for (const double isovalue : { 1.0, 5.0, 13.0, 19.0 })
  {
    const Surface surface = ExtractBlocks(volume, 16, MakeDroppingRequest({ isovalue }), 2);
    ASSERT_GT(surface.NumberOfTriangles, 0u);
    CheckPoints(surface);
    EXPECT_TRUE(IsManifold(MakePlain(surface))) << isovalue;
    ContourRequest all = MakeDroppingRequest({ isovalue });
    all.DropDegenerateTriangles = false;
    EXPECT_LT(surface.NumberOfTriangles, ExtractBlocks(volume, 16, all).NumberOfTriangles);
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
        volume.At(v) = 0;
      }
    }
  }
  EXPECT_TRUE(IsClosed(MakePlain(ExtractBlocks(volume, 16, MakeDroppingRequest({ 2.0 })))));
}

TEST(DegenerateTriangles, UnionOfRanksEqualsOneRank)
{
  std::mt19937 random(53);
  for (int trial = 0; trial < ChooseTrials(100); ++trial)
  {
    const auto volume = MakeRandomVolume<std::uint8_t>(random, { 9, 8, 7 }, 4);
    const int blockSize = 1 + trial % 4;
    const ContourRequest request = MakeDroppingRequest({ 2.0, 3.0 });
    const auto blocks = TestBlockSource<std::uint8_t>(volume, blockSize).Blocks;
    const Surface whole = ExtractBlocks(volume, blockSize, request);
    CheckPoints(whole);
    EXPECT_TRUE(UniteRanks(ExtractPieces(
                  volume, blockSize, request, blocks, 2 + trial % 3, random)) == MakePlain(whole));
  }
}

TEST(DegenerateTriangles, TheResultDoesNotDependOnThreads)
{
  std::mt19937 random(54);
  const auto volume = MakeRandomVolume<std::int16_t>(random, { 50, 40, 35 }, 8);
  const Surface one = ExtractBlocks(volume, 16, MakeDroppingRequest({ 1.0, 2.0 }), 1);
  for (const int threads : { 2, 5 })
  {
    ExpectSameSurface(ExtractBlocks(volume, 16, MakeDroppingRequest({ 1.0, 2.0 }), threads), one);
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
  ContourRequest request = MakeDroppingRequest({ 0.0 });
  request.Attributes = { { ValueType::Float64, 1 } };
  const auto surface = Require(ExtractSurface(volume.Geometry, source, request, 1));
  ASSERT_EQ(surface.NumberOfPoints, 30u);
  const auto* values = reinterpret_cast<const double*>(surface.Attributes[0].Bytes.GetData());
  for (std::size_t point = 0; point < 30; ++point)
  {
    const float* place = &surface.Points[3 * point];
    EXPECT_EQ(place[0], 9.0f);
    const auto vertex = static_cast<std::size_t>(9 + 20 * place[1] + 100 * place[2]);
    EXPECT_EQ(values[point], field[vertex]);
    EXPECT_EQ(surface.Normals[3 * point], -1.0f);
    EXPECT_EQ(surface.GlobalIds[point], static_cast<std::int64_t>(3 * 600 + vertex));
  }
}
