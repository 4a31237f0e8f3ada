// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/TriangleSet.h"
#include "Surface/Contour/SurfaceMerge.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <utility>

using namespace isosurface;

namespace
{

template <typename T>
void CheckUnionOfSubsets(
  const SampleVolume<T>& volume, int blockSize, double isovalue, int ranks, std::mt19937& random)
{
  const auto blocks = TestBlockSource<T>(volume, blockSize).Blocks;
  EXPECT_TRUE(UniteRanks(ExtractPieces(volume, blockSize, MakePlainRequest({ isovalue }), blocks,
                ranks, random)) == ContourPlainly(volume, { isovalue }));
}

void ExpectSameIndices(const IndexArray& a, const IndexArray& b)
{
  ASSERT_GT(a.GetSize(), 0u);
  ASSERT_EQ(a.GetSize(), b.GetSize());
  for (std::size_t n = 0; n < a.GetSize(); ++n)
  {
    ASSERT_EQ(a[n], b[n]) << n;
  }
}

} // namespace

TEST(SurfaceSharing, TheUnionOfSubsetsOfBlocksEqualsTheWhole)
{
  std::mt19937 random(40);
  std::uniform_int_distribution<int> size(2, 12);
  for (int trial = 0; trial < 400; ++trial)
  {
    const Index3 dimensions{ size(random), size(random), size(random) };
    const auto volume = MakeRandomVolume<std::uint8_t>(random, dimensions, 100);
    CheckUnionOfSubsets(volume, 1 + static_cast<int>(random() % 4), 60.5, 2 + trial % 3, random);
  }
}

TEST(SurfaceSharing, TheUnionOfSubsetsOfLargeBlocksEqualsTheWhole)
{
  std::mt19937 random(41);
  for (int trial = 0; trial < 3; ++trial)
  {
    const auto volume = MakeRandomVolume<float>(random, { 70, 35, 66 }, 1000);
    CheckUnionOfSubsets(volume, trial == 0 ? 16 : trial == 1 ? 32 : 64, 480.0, 3, random);
  }
}

TEST(SurfaceSharing, MergedSurfacesOfWideIndicesEqualNarrowOnes)
{
  std::mt19937 random(44);
  const auto volume = MakeRandomVolume<std::uint8_t>(random, { 30, 20, 25 }, 100);
  TestBlockSource<std::uint8_t> source(volume, 16);
  for (const bool polygons : { false, true })
  {
    std::vector<Surface> merged;
    for (const bool isWide : { false, true })
    {
      ContourRequest request = MakePlainRequest({ 50.5 });
      request.Offsets = true;
      request.Polygons = polygons;
      std::vector<Surface> parts;
      for (std::int64_t part = 0; part < 2; ++part)
      {
        source.Blocks = { part, part + 2 };
        request.WideIndices = isWide && part == 1;
        auto surface = Require(ExtractSurface(volume.Geometry, source, request, 1));
        parts.push_back(std::move(surface));
      }
      merged.push_back(MergeSurfaces(parts));
      EXPECT_EQ(merged.back().Connectivity.Is64Bit, isWide);
      EXPECT_EQ(merged.back().Offsets.Is64Bit, isWide);
    }
    ExpectSameIndices(merged[0].Connectivity, merged[1].Connectivity);
    ExpectSameIndices(merged[0].Offsets, merged[1].Offsets);
  }
}

TEST(SurfaceSharing, ASurfaceAwayFromTheBorderIsAClosedManifold)
{
  std::mt19937 random(42);
  auto volume = MakeRandomVolume<std::int16_t>(random, { 40, 37, 35 }, 1000);
  const Index3 size = volume.GetDimensions();
  VisitVertices(VertexBox{ {}, size },
    [&](const Index3& vertex)
    {
      const auto [i, j, k] = vertex;
      if (i == 0 || j == 0 || k == 0 || i == size[0] - 1 || j == size[1] - 1 || k == size[2] - 1)
      {
        volume.At(vertex) = -1000;
      }
    });
  EXPECT_TRUE(IsManifold(MakePlain(ExtractBlocks(volume, 16, MakePlainRequest({ 100.0 }), 2))));
}

TEST(SurfaceSharing, PolygonsAreTheLoopsOfTheTriangles)
{
  std::mt19937 random(43);
  const auto volume = MakeRandomVolume<std::uint16_t>(random, { 24, 19, 35 }, 60000);
  ContourRequest request = MakePlainRequest({ 30000.0 });
  const Surface triangles = ExtractBlocks(volume, 16, request);
  request.Polygons = true;
  const Surface polygons = ExtractBlocks(volume, 16, request, 2);
  EXPECT_EQ(triangles.NumberOfTriangles, polygons.NumberOfTriangles);
  EXPECT_TRUE(AreSame(triangles.Points, polygons.Points));
  ASSERT_EQ(polygons.Offsets.GetSize(), polygons.NumberOfCells + 1);
  ASSERT_EQ(static_cast<std::size_t>(polygons.Offsets[polygons.NumberOfCells]),
    polygons.Connectivity.GetSize());

  // The cells are in the same order: the next polygon of n corners is the next n - 2 triangles, and
  // its sides are the sides that only one of these triangles has.
  using Side = std::pair<std::int64_t, std::int64_t>;
  std::size_t triangle = 0;
  for (std::size_t polygon = 0; polygon < polygons.NumberOfCells; ++polygon)
  {
    const auto begin = static_cast<std::size_t>(polygons.Offsets[polygon]);
    const auto end = static_cast<std::size_t>(polygons.Offsets[polygon + 1]);
    ASSERT_GE(end - begin, 3u);
    std::map<Side, int> outline;
    for (std::size_t n = begin; n < end; ++n)
    {
      ++outline[{ polygons.Connectivity[n], polygons.Connectivity[n + 1 == end ? begin : n + 1] }];
    }
    for (std::size_t last = triangle + end - begin - 2; triangle < last; ++triangle)
    {
      for (std::size_t n = 0; n < 3; ++n)
      {
        const std::int64_t from = triangles.Connectivity[3 * triangle + n];
        const std::int64_t to = triangles.Connectivity[3 * triangle + (n + 1) % 3];
        // Inner sides occur in both directions and cancel out.
        --outline[{ from, to }];
        if (outline[{ from, to }] < 0 && outline[{ to, from }] < 0)
        {
          outline[{ from, to }] = outline[{ to, from }] = 0;
        }
      }
    }
    for (const auto& side : outline)
    {
      ASSERT_EQ(side.second, 0);
    }
  }
  EXPECT_EQ(triangle, triangles.NumberOfTriangles);
}

namespace
{

/// A volume with two attributes, which are linear functions of the vertex, so that their
/// interpolated values are linear functions of the point: its place, and 10 times its x coordinate.
class AttributeSource : public TestBlockSource<float>
{
public:
  explicit AttributeSource(const SampleVolume<float>& volume)
    : TestBlockSource<float>(volume, 16)
  {
    const Index3 size = volume.GetDimensions();
    VisitVertices(VertexBox{ {}, size },
      [&](const Index3& vertex)
      {
        const auto [i, j, k] = vertex;
        this->Places.insert(this->Places.end(), { double(i), double(j), double(k) });
        this->Integers.push_back(static_cast<std::int16_t>(10 * i));
      });
    AttributeView places;
    for (std::size_t component = 0; component < 3; ++component)
    {
      SampleView view = volume.GetView();
      view.Type = ValueType::Float64;
      view.First = &this->Places[component];
      for (std::ptrdiff_t& stride : view.Stride)
      {
        stride *= 3;
      }
      places.Components.push_back(view);
    }
    SampleView integers = volume.GetView();
    integers.Type = ValueType::Int16;
    integers.First = this->Integers.data();
    this->Attributes = { places, { { integers } } };
  }

  Result<BlockSamples> Acquire(std::size_t block) override
  {
    Result<BlockSamples> samples = TestBlockSource<float>::Acquire(block);
    samples->Attributes = this->Attributes;
    return samples;
  }

private:
  std::vector<double> Places;
  std::vector<std::int16_t> Integers;
  std::vector<AttributeView> Attributes;
};

} // namespace

TEST(SurfaceSharing, AttributesAreInterpolatedAlongTheEdges)
{
  std::mt19937 random(44);
  const auto volume = MakeRandomVolume<float>(random, { 20, 18, 17 }, 1000);
  AttributeSource source(volume);
  ContourRequest request = MakePlainRequest({ 300.5 });
  request.Attributes = { { ValueType::Float64, 3 }, { ValueType::Int16, 1 } };
  const auto surface = Require(ExtractSurface(volume.Geometry, source, request, 2));
  ASSERT_GT(surface.NumberOfPoints, 0u);
  const auto* vector = reinterpret_cast<const double*>(surface.Attributes[0].Bytes.GetData());
  ASSERT_EQ(surface.Attributes[1].Layout.Type, ValueType::Float32);
  const auto* integer = reinterpret_cast<const float*>(surface.Attributes[1].Bytes.GetData());
  for (std::size_t n = 0; n < 3 * surface.NumberOfPoints; ++n)
  {
    if (!std::isnan(surface.Points[n]))
    {
      ASSERT_EQ(static_cast<float>(vector[n]), surface.Points[n]);
      if (n % 3 == 0)
      {
        ASSERT_NEAR(integer[n / 3], 10 * vector[n], 1e-4);
      }
    }
  }
}
