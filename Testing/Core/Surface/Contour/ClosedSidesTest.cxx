// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/LongTests.h"
#include "Fixtures/TriangleSet.h"
#include "Ground/Volume/BlockSelection.h"
#include "Surface/Contour/GridBlockSource.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

using namespace isosurface;

namespace
{

ContourRequest MakeClosedRequest(std::vector<double> isovalues)
{
  ContourRequest request = MakePlainRequest(std::move(isovalues));
  request.ClosedSides = GridSides::All();
  return request;
}

template <typename T>
std::vector<std::int64_t> FindClosedBlocks(
  const SampleVolume<T>& volume, int blockSize, const ContourRequest& request)
{
  return FindBlocksByForce(
    volume, BlockGrid(volume.GetDimensions(), blockSize), request.Isovalues, true);
}

/// The volume with a layer around it that is outside (or inside): how the oracle closes a surface.
template <typename T>
SampleVolume<double> Pad(const SampleVolume<T>& volume, double beyond = -1e30)
{
  const Index3 size = volume.GetDimensions();
  SampleVolume<double> padded({ size[0] + 2, size[1] + 2, size[2] + 2 });
  std::fill(padded.Samples.begin(), padded.Samples.end(), beyond);
  for (std::size_t side = 0; side < 6; ++side)
  {
    padded.Geometry.Extent[side] = volume.Geometry.Extent[side] + (side % 2 == 0 ? -1 : 1);
  }
  VisitVertices(VertexBox{ {}, size },
    [&](const Index3& vertex)
    {
      const auto [i, j, k] = vertex;
      padded.At(i + 1, j + 1, k + 1) = static_cast<double>(volume.At(vertex));
    });
  return padded;
}

template <typename T>
Surface ExtractClosed(
  const SampleVolume<T>& volume, int blockSize, const ContourRequest& request, int threads = 1)
{
  TestBlockSource<T> source(volume, blockSize);
  source.Blocks = FindClosedBlocks(volume, blockSize, request);
  return Require(ExtractSurface(volume.Geometry, source, request, threads));
}

template <typename T>
PlainSurface ExtractPlain(
  const SampleVolume<T>& volume, int blockSize, const ContourRequest& request, int threads = 1)
{
  const Surface surface = ExtractClosed(volume, blockSize, request, threads);
  PlainSurface plain = MakePlain(surface);
  EXPECT_EQ(plain.Points.size(), surface.NumberOfPoints) << "an id is there twice";
  return plain;
}

template <typename T>
void CheckAgainstPadding(const SampleVolume<T>& volume, int blockSize,
  const std::vector<double>& isovalues, int threads = 1)
{
  const TriangleSet expected =
    Clamp(MakeTriangleSet(ContourPlainly(Pad(volume), isovalues)), volume.Geometry);
  ContourRequest request = MakeClosedRequest(isovalues);
  const PlainSurface closed = ExtractPlain(volume, blockSize, request, threads);
  EXPECT_EQ(MakeTriangleSet(closed), expected);
  EXPECT_TRUE(IsClosed(closed));
  request.DropDegenerateTriangles = true;
  const PlainSurface lean = ExtractPlain(volume, blockSize, request, threads);
  EXPECT_EQ(MakeTriangleSet(lean), DropDegenerate(expected));
  EXPECT_TRUE(IsClosed(lean));
}

/// The same triangles, seen from the other side.
TriangleSet Turn(const TriangleSet& set)
{
  TriangleSet turned;
  for (const auto& triangle : set)
  {
    AddTriangle(turned, { triangle[0], triangle[2], triangle[1] });
  }
  std::sort(turned.begin(), turned.end());
  return turned;
}

template <typename T>
double MeasureVolume(const SampleVolume<T>& volume, ContourRequest request, bool isBelow)
{
  request.ClosedSides.AreBeyondInside = isBelow;
  TestBlockSource<T> source(volume, 16);
  const Surface surface = Require(ExtractSurface(volume.Geometry, source, request, 1));
  double sum = 0;
  for (std::size_t triangle = 0; triangle < surface.NumberOfTriangles; ++triangle)
  {
    const float* corners[3];
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
      corners[corner] = surface.Points.GetData() + 3 * surface.Connectivity[3 * triangle + corner];
    }
    const auto [a, b, c] = corners;
    sum += (double{ a[0] } * (double{ b[1] } * c[2] - double{ b[2] } * c[1]) +
             double{ a[1] } * (double{ b[2] } * c[0] - double{ b[0] } * c[2]) +
             double{ a[2] } * (double{ b[0] } * c[1] - double{ b[1] } * c[0])) /
      6;
  }
  return sum;
}

template <typename T>
class ClosedSidesOfType : public testing::Test
{
};
using TypesOfClosedSides = testing::Types<std::uint8_t, std::int16_t, std::uint32_t, float, double>;
TYPED_TEST_SUITE(ClosedSidesOfType, TypesOfClosedSides);

} // namespace

TYPED_TEST(ClosedSidesOfType, RandomGridsEqualPaddedOnesMovedIntoTheGrid)
{
  std::mt19937 random(60);
  std::uniform_int_distribution<int> size(2, 8);
  for (int trial = 0; trial < ChooseTrials(150); ++trial)
  {
    SampleVolume<TypeParam> volume({ size(random), size(random), size(random) });
    for (TypeParam& sample : volume.Samples)
    {
      sample = static_cast<TypeParam>(random() % 5);
    }
    CheckAgainstPadding(volume, 1 + static_cast<int>(random() % 5),
      trial % 3 == 0 ? std::vector<double>{ 1.5, 2.0 } : std::vector<double>{ trial % 3 + 0.5 });
  }
}

TYPED_TEST(ClosedSidesOfType, WhatIsBelowIsBoundByTheTurnedTrianglesOfGridsPaddedInside)
{
  std::mt19937 random(63);
  std::uniform_int_distribution<int> size(2, 8);
  for (int trial = 0; trial < ChooseTrials(150); ++trial)
  {
    SampleVolume<TypeParam> volume({ size(random), size(random), size(random) });
    for (TypeParam& sample : volume.Samples)
    {
      sample = static_cast<TypeParam>(random() % 5);
    }
    ContourRequest request = MakeClosedRequest({ trial % 5 + 0.5 });
    request.ClosedSides.AreBeyondInside = true;
    const TriangleSet expected = Turn(Clamp(
      MakeTriangleSet(ContourPlainly(Pad(volume, 1e30), request.Isovalues)), volume.Geometry));
    for (const bool drops : { false, true })
    {
      request.DropDegenerateTriangles = drops;
      TestBlockSource<TypeParam> source(volume, 1 + trial % 4);
      const Surface surface = Require(ExtractSurface(volume.Geometry, source, request, 1));
      const PlainSurface below = MakePlain(surface);
      // A triangle of two equal corners may begin with either.
      EXPECT_TRUE(DropDegenerate(MakeTriangleSet(below)) == DropDegenerate(expected));
      EXPECT_EQ(below.Triangles.size(), (drops ? DropDegenerate(expected) : expected).size());
      EXPECT_TRUE(IsClosed(below));
    }
  }
}

TEST(ClosedSides, WhatIsAboveAndWhatIsBelowFillTheGrid)
{
  std::mt19937 random(64);
  const auto volume = MakeRandomVolume<std::int16_t>(random, { 33, 20, 18 }, 9);
  ContourRequest request = MakeClosedRequest({ 3.5 });
  const double above = MeasureVolume(volume, request, false);
  const double below = MeasureVolume(volume, request, true);
  EXPECT_GT(above, 0);
  EXPECT_GT(below, 0);
  EXPECT_NEAR(above + below, 32.0 * 19 * 17, 0.01);
}

TEST(ClosedSides, NormalsOfWhatIsBelowPointOutOfIt)
{
  std::mt19937 random(65);
  const auto volume = MakeRandomVolume<std::int16_t>(random, { 12, 9, 7 }, 9);
  ContourRequest request = MakePlainRequest({ 3.5 });
  request.Normals = true;
  TestBlockSource<std::int16_t> source(volume, 16);
  const Surface plain = Require(ExtractSurface(volume.Geometry, source, request, 1));
  std::map<Place, Place> normals;
  const auto get = [](const Buffer<float>& values, std::size_t point) {
    return Place{ values[3 * point], values[3 * point + 1], values[3 * point + 2] };
  };
  for (std::size_t point = 0; point < plain.NumberOfPoints; ++point)
  {
    normals[get(plain.Points, point)] = get(plain.Normals, point);
  }
  request.ClosedSides = GridSides::All();
  request.ClosedSides.AreBeyondInside = true;
  const Surface below = Require(ExtractSurface(volume.Geometry, source, request, 1));
  std::size_t caps = 0;
  for (std::size_t point = 0; point < below.NumberOfPoints; ++point)
  {
    const Place place = get(below.Points, point);
    const Place normal = get(below.Normals, point);
    const auto found = normals.find(place);
    if (found != normals.end())
    {
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        EXPECT_EQ(normal[axis], -found->second[axis]);
      }
      continue;
    }
    ++caps;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const auto last = static_cast<float>(volume.GetDimensions()[axis] - 1);
      EXPECT_TRUE(normal[axis] == 0 || place[axis] == (normal[axis] > 0 ? last : 0.0F));
    }
  }
  EXPECT_GT(caps, 20u);
}

TEST(ClosedSides, BlocksOfAllSizesEqualPaddedGrids)
{
  std::mt19937 random(61);
  for (const Index3& dimensions : { Index3{ 70, 5, 34 }, Index3{ 4, 67, 3 }, Index3{ 33, 65, 2 } })
  {
    const auto volume = MakeRandomVolume<std::int16_t>(random, dimensions, 20);
    for (const int blockSize : { 16, 32, 64 })
    {
      CheckAgainstPadding(volume, blockSize, { 4.25 }, 2);
    }
  }
}

TEST(ClosedSides, NegativeExtentsEqualPaddedGrids)
{
  std::mt19937 random(62);
  auto volume = MakeRandomVolume<std::uint16_t>(random, { 19, 8, 12 }, 40);
  volume.Geometry.Extent = { -1000, -982, 7, 14, -12, -1 };
  CheckAgainstPadding(volume, 16, { 30.0 });
}

TEST(ClosedSides, AnIsovalueBelowAllSamplesGivesTheBoxOfTheGrid)
{
  // No value is below the minimum of the type, but beyond the grid everything is outside.
  for (const double isovalue : { -5.0, 0.0 })
  {
    SampleVolume<std::uint8_t> volume({ 20, 6, 37 });
    ContourRequest request = MakeClosedRequest({ isovalue });
    request.DropDegenerateTriangles = true;
    const PlainSurface box = ExtractPlain(volume, 16, request);
    EXPECT_TRUE(IsManifold(box));
    EXPECT_NEAR(ComputeSixfoldVolume(MakeTriangleSet(box)), 6.0 * 19 * 5 * 36, 1e-6);
    // Two triangles for each face of a cell at the border, and no others.
    EXPECT_EQ(box.Triangles.size(), 4u * (19 * 5 + 5 * 36 + 36 * 19));
  }
}

TEST(ClosedSides, CapsHaveOutwardNormals)
{
  SampleVolume<float> volume({ 9, 8, 7 });
  std::fill(volume.Samples.begin(), volume.Samples.end(), 1.0f);
  const PlainSurface box = ExtractPlain(volume, 4, MakeClosedRequest({ 0.5 }));
  const float high[] = { 8, 7, 6 };
  for (const auto& [id, bits] : box.Points)
  {
    float values[6];
    std::memcpy(values, bits.data(), sizeof(values));
    int axes = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      if (values[3 + axis] != 0)
      {
        ++axes;
        EXPECT_EQ(values[axis], values[3 + axis] > 0 ? high[axis] : 0.0f);
        EXPECT_EQ(std::abs(values[3 + axis]), 1.0f);
      }
    }
    EXPECT_EQ(axes, 1);
  }
}

TEST(ClosedSides, PointsOffTheCapsAreThoseOfTheOpenSurface)
{
  std::mt19937 random(63);
  const auto volume = MakeRandomVolume<std::int16_t>(random, { 35, 20, 18 }, 1000);
  ContourRequest request = MakeClosedRequest({ 100.5 });
  const PlainSurface closed = ExtractPlain(volume, 16, request);
  request.ClosedSides = {};
  const PlainSurface open = ExtractPlain(volume, 16, request);
  std::multiset<PointBits> closedPoints;
  for (const auto& [id, bits] : closed.Points)
  {
    closedPoints.insert(bits);
  }
  for (const auto& [id, bits] : open.Points)
  {
    ASSERT_GE(closedPoints.count(bits), 1u) << "a point or normal changed";
  }
}

TEST(ClosedSides, OnlyTheRequestedSidesAreClosed)
{
  SampleVolume<std::uint8_t> volume({ 6, 7, 8 });
  std::fill(volume.Samples.begin(), volume.Samples.end(), std::uint8_t(9));
  for (std::size_t side = 0; side < 6; ++side)
  {
    ContourRequest request = MakeClosedRequest({ 3.0 });
    request.ClosedSides = {};
    request.ClosedSides.Sides[side] = true;
    const PlainSurface cap = ExtractPlain(volume, 4, request);
    const std::size_t axis = side / 2;
    const Index3 size = volume.GetDimensions();
    const auto cells =
      static_cast<std::size_t>((size[(axis + 1) % 3] - 1) * (size[(axis + 2) % 3] - 1));
    EXPECT_EQ(cap.Triangles.size(), 2 * cells);
    for (const auto& [id, bits] : cap.Points)
    {
      float place[3];
      std::memcpy(place, bits.data(), sizeof(place));
      EXPECT_EQ(place[axis], side % 2 == 0 ? 0.0f : static_cast<float>(size[axis] - 1));
    }
  }
}

TEST(ClosedSides, UnionOfRanksEqualsOneRank)
{
  std::mt19937 random(64);
  for (int trial = 0; trial < ChooseTrials(120); ++trial)
  {
    const auto volume = MakeRandomVolume<std::uint8_t>(random, { 9, 8, 7 }, 4);
    const int blockSize = 1 + trial % 4;
    ContourRequest request = MakeClosedRequest({ 2.0, 2.5 });
    request.DropDegenerateTriangles = trial % 2 == 0;
    const PlainSurface united = UniteRanks(ExtractPieces(volume, blockSize, request,
      FindClosedBlocks(volume, blockSize, request), 2 + trial % 3, random));
    EXPECT_TRUE(united == ExtractPlain(volume, blockSize, request));
    EXPECT_TRUE(IsClosed(united));
  }
}

TEST(ClosedSides, CapsOfPolygonsCloseTheSurface)
{
  std::mt19937 random(65);
  const auto volume = MakeRandomVolume<std::uint8_t>(random, { 20, 9, 8 }, 100);
  ContourRequest request = MakeClosedRequest({ 50.5 });
  request.Polygons = true;
  const Surface surface = ExtractClosed(volume, 16, request);
  std::map<std::pair<std::int64_t, std::int64_t>, int> sides;
  for (std::size_t cell = 0; cell < surface.NumberOfCells; ++cell)
  {
    const auto begin = static_cast<std::size_t>(surface.Offsets[cell]);
    const auto end = static_cast<std::size_t>(surface.Offsets[cell + 1]);
    for (std::size_t n = begin; n < end; ++n)
    {
      const std::int64_t from = surface.Connectivity[n];
      const std::int64_t to = surface.Connectivity[n + 1 == end ? begin : n + 1];
      sides[std::minmax(from, to)] += from < to ? 1 : -1;
    }
  }
  for (const auto& side : sides)
  {
    ASSERT_EQ(side.second, 0);
  }
}

TEST(ClosedSides, AttributesOfCapsAreThoseOfTheBorder)
{
  std::mt19937 random(66);
  const auto volume = MakeRandomVolume<float>(random, { 18, 9, 8 }, 100);
  std::vector<float> field(volume.Samples.size());
  const Index3 size = volume.GetDimensions();
  for (std::size_t n = 0; n < field.size(); ++n)
  {
    field[n] = static_cast<float>(n % static_cast<std::size_t>(size[0]));
  }
  const auto ranges = BlockRanges::Compute(volume.GetView(), 1);
  ContourRequest request = MakeClosedRequest({ 20.5 });
  request.Attributes = { { ValueType::Float32, 1 } };
  SampleView view = volume.GetView();
  view.First = field.data();
  for (const bool drop : { false, true })
  {
    request.DropDegenerateTriangles = drop;
    BlockSelection selection;
    selection.ClosedSides = request.ClosedSides;
    GridBlockSource source(
      volume.GetView(), *ranges, request.Isovalues, selection, volume.Geometry);
    source.SetAttributes({ { { view } } });
    const auto surface = Require(ExtractSurface(volume.Geometry, source, request, 1));
    const auto* x = reinterpret_cast<const float*>(surface.Attributes[0].Bytes.GetData());
    for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
    {
      if (!std::isnan(surface.Points[3 * point]))
      {
        ASSERT_EQ(x[point], surface.Points[3 * point]);
      }
    }
  }
}

TEST(BlockSelection, BlocksOfSamplesInMemoryEqualBruteForce)
{
  std::mt19937 random(67);
  SampleVolume<std::int16_t> volume({ 70, 100, 66 });
  for (std::size_t n = 0; n < volume.Samples.size(); ++n)
  {
    volume.Samples[n] = static_cast<std::int16_t>(n / 5000);
  }
  const auto ranges = BlockRanges::Compute(volume.GetView(), 2);
  for (const std::vector<double>& isovalues :
    { std::vector<double>{ 30.0 }, { 10.0, 60.5 }, { -1.0 }, { 1000.0 } })
  {
    for (const bool closed : { false, true })
    {
      BlockSelection selection;
      selection.ClosedSides = closed ? GridSides::All() : GridSides{};
      const GridBlockSource source(
        volume.GetView(), *ranges, isovalues, selection, volume.Geometry);
      const BlockGrid grid(volume.GetDimensions(), BlockRanges::BlockSize);
      const auto expected = FindBlocksByForce(volume, grid, isovalues, closed);
      ASSERT_EQ(source.GetNumberOfBlocks(), expected.size());
      for (std::size_t block = 0; block < expected.size(); ++block)
      {
        EXPECT_EQ(source.GetVertices(block), grid.GetVertices(expected[block]));
      }
    }
  }
}
