// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/PlainContour.h"
#include "Fixtures/TestBlockSource.h"
#include "Fixtures/TriangleSet.h"
#include "Surface/Contour/BlockRanges.h"
#include "Surface/Contour/GridBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <set>
#include <vector>

using namespace isosurface;

namespace
{

// Flags of the cells and vertices of a volume, some of them hidden.
struct Flags
{
  std::vector<std::uint8_t> Cells;
  std::vector<std::uint8_t> Vertices;
  Index3 Size{};

  Flags(const Index3& size, std::mt19937& random)
    : Cells(static_cast<std::size_t>((size[0] - 1) * (size[1] - 1) * (size[2] - 1)))
    , Vertices(static_cast<std::size_t>(size[0] * size[1] * size[2]))
    , Size(size)
  {
    for (std::uint8_t& cell : this->Cells)
    {
      cell = static_cast<std::uint8_t>(random() % 9 == 0 ? 8 : random() % 9 == 0 ? 32 : 1);
    }
    for (std::uint8_t& vertex : this->Vertices)
    {
      vertex = static_cast<std::uint8_t>(random() % 60 == 0 ? 2 : 1);
    }
  }

  Blanking GetBlanking() const
  {
    Blanking hidden;
    hidden.Box = { { 0, 0, 0 }, this->Size };
    hidden.Cells = this->Cells.data();
    hidden.HidesCell = 8 | 32;
    hidden.Vertices = this->Vertices.data();
    hidden.HidesVertex = 2;
    return hidden;
  }

  bool IsVisible(const Index3& cell) const
  {
    const Index3 cells{ this->Size[0] - 1, this->Size[1] - 1, this->Size[2] - 1 };
    bool isVisible =
      (this->Cells[static_cast<std::size_t>(cell[0] + cells[0] * (cell[1] + cells[1] * cell[2]))] &
        (8 | 32)) == 0;
    for (std::int64_t n = 0; n < 8; ++n)
    {
      const std::int64_t vertex =
        cell[0] + n % 2 + this->Size[0] * (cell[1] + n / 2 % 2 + this->Size[1] * (cell[2] + n / 4));
      isVisible = isVisible && (this->Vertices[static_cast<std::size_t>(vertex)] & 2) == 0;
    }
    return isVisible;
  }

  bool IsKnown(const Index3& vertex) const
  {
    for (std::int64_t n = 0; n < 8; ++n)
    {
      const Index3 cell{ vertex[0] - n % 2, vertex[1] - n / 2 % 2, vertex[2] - n / 4 };
      bool isCell = true;
      for (int axis = 0; axis < 3; ++axis)
      {
        isCell = isCell && cell[axis] >= 0 && cell[axis] + 1 < this->Size[axis];
      }
      if (isCell && this->IsVisible(cell))
      {
        return true;
      }
    }
    return false;
  }
};

// Without the points that are in no triangle.
PlainSurface KeepUsed(PlainSurface surface)
{
  std::set<std::int64_t> used;
  for (const auto& triangle : surface.Triangles)
  {
    used.insert(triangle.begin(), triangle.end());
  }
  for (auto point = surface.Points.begin(); point != surface.Points.end();)
  {
    point = used.count(point->first) != 0 ? std::next(point) : surface.Points.erase(point);
  }
  return surface;
}

template <typename T>
Surface ExtractBlanked(
  const SampleVolume<T>& volume, const Flags& flags, const ContourRequest& request, int threads)
{
  const SampleView view = volume.GetView();
  const BlockRanges ranges = *BlockRanges::Compute(view, 1);
  GridBlockSource source(view, ranges, request.Isovalues);
  source.SetBlanking(flags.GetBlanking());
  auto surface = ExtractSurface(volume.Geometry, source, request, threads);
  EXPECT_TRUE(surface.IsOk()) << surface.GetStatus().GetMessage();
  return std::move(*surface);
}

template <typename T>
void ExpectVisibleCellsAlone(const Index3& size, unsigned int seed)
{
  std::mt19937 random(seed);
  SampleVolume<T> volume(size);
  for (T& sample : volume.Samples)
  {
    sample = static_cast<T>(random() % 100);
  }
  const Flags flags(size, random);
  const std::vector<double> isovalues = { 30.5, 50.0 };
  PlainSurface expected;
  for (std::size_t n = 0; n < isovalues.size(); ++n)
  {
    const PlainContour<T> plain(
      volume, [&](const Index3& cell) { return flags.IsVisible(cell); },
      [&](const Index3& vertex) { return flags.IsKnown(vertex); });
    plain.Contour(isovalues[n],
      static_cast<std::int64_t>(n) * 3 * volume.Geometry.GetNumberOfVertices(), expected);
  }
  for (const int threads : { 1, 3 })
  {
    const Surface surface = ExtractBlanked(volume, flags, MakePlainRequest(isovalues), threads);
    EXPECT_EQ(MakePlain(surface).Triangles, expected.Triangles);
    EXPECT_TRUE(MakePlain(surface) == expected);
    EXPECT_EQ(KeepUsed(MakePlain(surface)).Points.size(), surface.NumberOfPoints);
  }
}

// Values with regions of NaN.
SampleVolume<float> MakeHoles(const Index3& size, unsigned int seed)
{
  std::mt19937 random(seed);
  SampleVolume<float> volume(size);
  for (float& sample : volume.Samples)
  {
    sample = random() % 70 == 0 ? std::numeric_limits<float>::quiet_NaN()
                                : static_cast<float>(random() % 100);
  }
  return volume;
}

bool HasNumbers(const SampleVolume<float>& volume, const Index3& cell)
{
  bool has = true;
  for (std::int64_t n = 0; n < 8; ++n)
  {
    has = has && !std::isnan(volume.At(cell[0] + n % 2, cell[1] + n / 2 % 2, cell[2] + n / 4));
  }
  return has;
}

} // namespace

TEST(CellVisibility, HiddenCellsAndVerticesHaveNoSurfaceAndNoInfluence)
{
  ExpectVisibleCellsAlone<float>({ 70, 35, 34 }, 1);
  ExpectVisibleCellsAlone<std::uint8_t>({ 33, 66, 9 }, 2);
  ExpectVisibleCellsAlone<std::int64_t>({ 9, 34, 67 }, 3);
  ExpectVisibleCellsAlone<double>({ 12, 11, 10 }, 4);
}

TEST(CellVisibility, FlagsOfOtherKindsHideNothing)
{
  std::mt19937 random(5);
  SampleVolume<float> volume(
    { 40, 20, 20 }, [&](auto...) { return static_cast<double>(random() % 100); });
  Flags flags(volume.GetDimensions(), random);
  flags.Cells.assign(flags.Cells.size(), 1 | 2 | 4 | 16);
  flags.Vertices.assign(flags.Vertices.size(), 1);
  const Surface surface = ExtractBlanked(volume, flags, MakePlainRequest({ 50 }), 1);
  EXPECT_TRUE(MakePlain(surface) == ContourPlainly(volume, { 50 }));
}

TEST(CellVisibility, PolygonsOfVisibleCellsHaveTheirTriangles)
{
  std::mt19937 random(6);
  SampleVolume<float> volume(
    { 40, 35, 20 }, [&](auto...) { return static_cast<double>(random() % 100); });
  const Flags flags(volume.GetDimensions(), random);
  ContourRequest request = MakePlainRequest({ 50 });
  const Surface triangles = ExtractBlanked(volume, flags, request, 2);
  request.Polygons = true;
  const Surface polygons = ExtractBlanked(volume, flags, request, 2);
  EXPECT_EQ(polygons.NumberOfTriangles, triangles.NumberOfTriangles);
  ASSERT_EQ(polygons.NumberOfPoints, triangles.NumberOfPoints);
  for (std::size_t point = 0; point < triangles.NumberOfPoints; ++point)
  {
    EXPECT_EQ(polygons.GlobalIds[point], triangles.GlobalIds[point]);
  }
  // Every corner of a polygon is one of its triangles' corners, as often as polygons have corners.
  EXPECT_EQ(
    polygons.Connectivity.GetSize(), polygons.NumberOfTriangles + 2 * polygons.NumberOfCells);
  std::set<std::int64_t> corners;
  for (std::size_t n = 0; n < polygons.Connectivity.GetSize(); ++n)
  {
    corners.insert(polygons.Connectivity[n]);
  }
  EXPECT_EQ(corners.size(), polygons.NumberOfPoints);
}

TEST(CellVisibility, HiddenCellsMeetDroppedDegenerateTriangles)
{
  std::mt19937 random(7);
  SampleVolume<std::uint8_t> volume(
    { 40, 35, 20 }, [&](auto...) { return static_cast<double>(random() % 5); });
  const Flags flags(volume.GetDimensions(), random);
  ContourRequest request = MakePlainRequest({ 2 });
  const TriangleSet all = MakeTriangleSet(MakePlain(ExtractBlanked(volume, flags, request, 2)));
  request.DropDegenerateTriangles = true;
  const TriangleSet kept = MakeTriangleSet(MakePlain(ExtractBlanked(volume, flags, request, 2)));
  EXPECT_EQ(kept, DropDegenerate(all));
  EXPECT_LT(kept.size(), all.size());
}

TEST(CellVisibility, CapsEndWhereCellsOfTheSideAreHidden)
{
  const SampleVolume<float> volume({ 6, 6, 6 }, [](auto...) { return 1.0; });
  std::mt19937 random(8);
  Flags flags(volume.GetDimensions(), random);
  flags.Cells.assign(flags.Cells.size(), 0);
  flags.Vertices.assign(flags.Vertices.size(), 0);
  ContourRequest request = MakePlainRequest({ 0.5 });
  request.ClosedSides = GridSides::All();
  const SampleView view = volume.GetView();
  const BlockRanges ranges = *BlockRanges::Compute(view, 1);
  GridBlockSource source(
    view, ranges, request.Isovalues, { request.ClosedSides, Region() }, volume.Geometry);
  const auto countTriangles = [&]
  {
    source.SetBlanking(flags.GetBlanking());
    return ExtractSurface(volume.Geometry, source, request, 1)->NumberOfTriangles;
  };
  const std::size_t all = countTriangles();
  flags.Cells[2 + 5 * 2] = 32; // in the middle of the side at z = 0
  EXPECT_EQ(countTriangles() + 2, all);
}

TEST(CellVisibility, CellsWithANotANumberAreLeftOutOnRequest)
{
  const SampleVolume<float> volume = MakeHoles({ 70, 35, 34 }, 9);
  const PlainContour<float> plain(
    volume, [&](const Index3& cell) { return HasNumbers(volume, cell); },
    [&](const Index3& vertex) { return !std::isnan(volume.At(vertex)); });
  PlainSurface expected;
  plain.Contour(50, 0, expected);
  for (const int blockSize : { 16, 32 })
  {
    TestBlockSource<float> source(volume, blockSize);
    ContourRequest request = MakePlainRequest({ 50 });
    request.SkipNotANumber = true;
    const auto surface = Require(ExtractSurface(volume.Geometry, source, request, 2));
    EXPECT_TRUE(MakePlain(surface) == expected) << blockSize;
    for (std::size_t n = 0; n < 3 * surface.NumberOfPoints; ++n)
    {
      ASSERT_FALSE(std::isnan(surface.Points[n]) || std::isnan(surface.Normals[n]));
    }
    request.SkipNotANumber = false;
    const auto walls = ExtractSurface(volume.Geometry, source, request, 2);
    EXPECT_TRUE(MakePlain(*walls) == ContourPlainly(volume, { 50 }));
  }
}
