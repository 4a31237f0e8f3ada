// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Drawing/TriangleMeasure.h"

#include "TriangleSamples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

using namespace isosurface;

namespace
{

std::uint64_t CountProperTriangles(const TriangleMeasure& measure)
{
  return std::accumulate(
    measure.ProperTriangles.begin(), measure.ProperTriangles.end(), std::uint64_t{ 0 });
}

std::array<float, 3> GetPlace(const OwnTriangles& surface, std::int32_t point)
{
  const float* place = surface.Points.data() + 3 * static_cast<std::size_t>(point);
  return { place[0], place[1], place[2] };
}

std::size_t CountTrianglesOfThreePlaces(const OwnTriangles& surface)
{
  std::size_t count = 0;
  for (std::size_t n = 0; n < surface.Triangles.size(); n += 3)
  {
    std::set<std::array<float, 3>> places;
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
      places.insert(GetPlace(surface, surface.Triangles[n + corner]));
    }
    count += places.size() == 3 ? 1 : 0;
  }
  return count;
}

template <typename PointsT>
std::array<double, 6> GetBoundsOf(const OwnTriangles& surface, const PointsT& points)
{
  std::array<double, 6> bounds = { 1e9, -1e9, 1e9, -1e9, 1e9, -1e9 };
  for (std::int32_t point : points)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double value = static_cast<double>(GetPlace(surface, point)[axis]);
      bounds[2 * axis] = std::min(bounds[2 * axis], value);
      bounds[2 * axis + 1] = std::max(bounds[2 * axis + 1], value);
    }
  }
  return bounds;
}

} // namespace

TEST(TriangleMeasure, CountsTrianglesOfThreePlacesInBothIntegerTypesOnAnyThreads)
{
  // More than a run of triangles.
  OwnTriangles surface = MakeRandomTriangles(500, 150000, 1);
  const std::size_t proper = CountTrianglesOfThreePlaces(surface);
  ASSERT_LT(proper, 149900U);
  for (int threads : { 1, 2, 5 })
  {
    EXPECT_EQ(CountProperTriangles(MeasureTriangles(surface.GetView(), threads)), proper);
    EXPECT_EQ(CountProperTriangles(MeasureTriangles(surface.GetView64(), threads)), proper);
  }
}

TEST(TriangleMeasure, BoundsAreThoseOfThePointsThatTrianglesUse)
{
  for (unsigned seed = 1; seed <= 20; ++seed)
  {
    OwnTriangles surface = MakeRandomTriangles(1000, 20, seed);
    surface.Points[3 * 77] = 1000; // a point that most likely is unused
    const std::set<std::int32_t> used(surface.Triangles.begin(), surface.Triangles.end());
    std::vector<std::int32_t> all(1000);
    std::iota(all.begin(), all.end(), 0);
    const TriangleMeasure measure = MeasureTriangles(surface.GetView(), 2);
    EXPECT_TRUE(measure.IsValid);
    EXPECT_EQ(measure.Bounds, GetBoundsOf(surface, used));
    EXPECT_EQ(measure.PointBounds, GetBoundsOf(surface, all));
  }
}

TEST(TriangleMeasure, BoundsOfManyRunsOfPointsAreThoseOfAll)
{
  OwnTriangles sphere = MakeSphere(400, 500);
  const TriangleMeasure measure = MeasureTriangles(sphere.GetView(), 3);
  const std::set<std::int32_t> used(sphere.Triangles.begin(), sphere.Triangles.end());
  EXPECT_EQ(measure.Bounds, GetBoundsOf(sphere, used));
  EXPECT_EQ(measure.Bounds, measure.PointBounds);
}

TEST(TriangleMeasure, NumbersThatAreNoPointsMakeASurfaceInvalid)
{
  for (std::int32_t number : { 10, -1, std::numeric_limits<std::int32_t>::max() })
  {
    OwnTriangles surface = MakeRandomTriangles(10, 20, 3);
    surface.Triangles[31] = number;
    EXPECT_FALSE(MeasureTriangles(surface.GetView(), 2).IsValid);
    EXPECT_FALSE(MeasureTriangles(surface.GetView64(), 2).IsValid);
  }
}

TEST(TriangleMeasure, ASurfaceWithoutTrianglesHasNoBounds)
{
  OwnTriangles surface;
  surface.Points = { 1, 2, 3 };
  const TriangleMeasure measure = MeasureTriangles(surface.GetView(), 2);
  EXPECT_TRUE(measure.IsValid);
  EXPECT_GT(measure.Bounds[0], measure.Bounds[1]);
  EXPECT_EQ(CountProperTriangles(measure), 0U);
}

TEST(TriangleMeasure, APointThatIsNotANumberIsInNoPlace)
{
  OwnTriangles surface;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  surface.Points = { nan, 0, 0, nan, 0, 0, 1, 0, 0 };
  surface.Triangles = { 0, 1, 2, 0, 0, 2 };
  EXPECT_EQ(CountProperTriangles(MeasureTriangles(surface.GetView(), 1)), 2U);
}

TEST(TriangleMeasure, OffsetsOfOtherCellsAreFoundWhereverTheyAre)
{
  const std::size_t cells = 600000;
  std::vector<std::int32_t> offsets(cells + 1);
  for (std::size_t cell = 0; cell <= cells; ++cell)
  {
    offsets[cell] = static_cast<std::int32_t>(3 * cell);
  }
  EXPECT_TRUE(AreTriangleOffsets(offsets.data(), cells, 2));
  for (std::size_t cell : { std::size_t{ 0 }, std::size_t{ 300000 }, cells })
  {
    std::vector<std::int64_t> others(offsets.begin(), offsets.end());
    EXPECT_TRUE(AreTriangleOffsets(others.data(), cells, 2));
    others[cell] += 1;
    EXPECT_FALSE(AreTriangleOffsets(others.data(), cells, 2));
  }
}
