// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Drawing/SurfaceThinning.h"

#include "TriangleSamples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

using namespace isosurface;

namespace
{

ThinnedSurface Thin(const TriangleSurface& surface, int cells, int threads = 2,
  std::size_t points = std::numeric_limits<std::size_t>::max())
{
  ThinningLimits limits;
  limits.Cells = cells;
  limits.Points = points;
  return ThinSurface(surface, MeasureTriangles(surface, threads), limits, threads);
}

double GetDistance(const float* a, const float* b)
{
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis)
  {
    sum += std::pow(static_cast<double>(a[axis]) - static_cast<double>(b[axis]), 2);
  }
  return std::sqrt(sum);
}

} // namespace

TEST(SurfaceThinning, KeepsOnePointInEachCellThatHasPointsTheOneNextToItsCentre)
{
  const OwnTriangles sphere = MakeSphere(60, 60);
  const int cells = 8;
  const TriangleMeasure measure = MeasureTriangles(sphere.GetView(), 1);
  double longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    longest = std::max(longest, measure.Bounds[2 * axis + 1] - measure.Bounds[2 * axis]);
  }
  std::map<std::array<int, 3>, double> nearest;
  const auto locate = [&](std::size_t point, double& distance)
  {
    std::array<int, 3> cell{};
    distance = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double length = measure.Bounds[2 * axis + 1] - measure.Bounds[2 * axis];
      const double place =
        (static_cast<double>(sphere.Points[3 * point + axis]) - measure.Bounds[2 * axis]) * cells /
        longest;
      cell[axis] =
        std::min(static_cast<int>(place), static_cast<int>(length * cells / longest + 1e-6));
      distance += std::pow(place - cell[axis] - 0.5, 2);
    }
    return cell;
  };
  for (std::size_t point = 0; point < sphere.Points.size() / 3; ++point)
  {
    double distance = 0;
    const std::array<int, 3> cell = locate(point, distance);
    const auto found = nearest.emplace(cell, distance).first;
    found->second = std::min(found->second, distance);
  }
  const ThinnedSurface thinned = Thin(sphere.GetView(), cells);
  ASSERT_EQ(thinned.Points.size(), nearest.size());
  for (std::uint32_t point : thinned.Points)
  {
    double distance = 0;
    const std::array<int, 3> cell = locate(point, distance);
    ASSERT_EQ(nearest.count(cell), 1U);
    EXPECT_NEAR(distance, nearest[cell], 1e-5);
    nearest.erase(cell);
  }
}

TEST(SurfaceThinning, EveryPointIsNearOneThatIsKept)
{
  const OwnTriangles sphere = MakeSphere(50, 50);
  const ThinnedSurface thinned = Thin(sphere.GetView(), 10);
  const double diagonal = std::sqrt(3.0) * 2 / 10;
  for (std::size_t point = 0; point < sphere.Points.size(); point += 3)
  {
    double distance = 10;
    for (std::uint32_t kept : thinned.Points)
    {
      distance = std::min(distance,
        GetDistance(
          sphere.Points.data() + point, sphere.Points.data() + 3 * static_cast<std::size_t>(kept)));
    }
    ASSERT_LE(distance, diagonal);
  }
}

TEST(SurfaceThinning, TrianglesHaveThreePointsThatAreKept)
{
  const OwnTriangles sphere = MakeSphere(200, 200);
  const ThinnedSurface thinned = Thin(sphere.GetView(), 20);
  ASSERT_GT(thinned.Triangles.size(), 3 * 500U);
  ASSERT_LT(thinned.Triangles.size(), sphere.Triangles.size() / 4);
  std::set<std::uint32_t> used;
  ASSERT_EQ(3 * thinned.Numbers.size(), thinned.Triangles.size());
  for (std::size_t n = 0; n < thinned.Triangles.size(); n += 3)
  {
    const std::set<std::uint32_t> corners(
      thinned.Triangles.begin() + static_cast<std::ptrdiff_t>(n),
      thinned.Triangles.begin() + static_cast<std::ptrdiff_t>(n + 3));
    ASSERT_EQ(corners.size(), 3U);
    ASSERT_LT(*corners.rbegin(), thinned.Points.size());
    used.insert(corners.begin(), corners.end());
    // A corner is the point of its cell: at most a diagonal away from the triangle's own one.
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
      const std::size_t own = sphere.Triangles[3 * std::size_t{ thinned.Numbers[n / 3] } + corner];
      const std::size_t kept = thinned.Points[thinned.Triangles[n + corner]];
      ASSERT_LE(GetDistance(sphere.Points.data() + 3 * own, sphere.Points.data() + 3 * kept),
        std::sqrt(3.0) * 2 / 20);
    }
  }
  // A cell that only the tip of a surface reaches into may have a point without triangles.
  EXPECT_GT(used.size(), thinned.Points.size() * 95 / 100);
}

TEST(SurfaceThinning, DoesNotDependOnThreadsOrTheIntegerType)
{
  OwnTriangles surface = MakeRandomTriangles(100000, 200000, 9);
  const ThinnedSurface one = Thin(surface.GetView(), 40, 1);
  for (int threads : { 2, 7 })
  {
    const ThinnedSurface several = Thin(surface.GetView64(), 40, threads);
    EXPECT_EQ(several.Points, one.Points);
    EXPECT_EQ(several.Triangles, one.Triangles);
  }
}

TEST(SurfaceThinning, KeepsAboutAsManyPointsAsWanted)
{
  const OwnTriangles sphere = MakeSphere(500, 500);
  for (std::size_t wanted : { 100U, 1000U, 10000U })
  {
    const ThinnedSurface thinned = Thin(sphere.GetView(), 512, 2, wanted);
    EXPECT_LE(thinned.Points.size(), wanted * 3 / 2);
    EXPECT_GE(thinned.Points.size(), wanted / 3);
  }
}

TEST(SurfaceThinning, SurfacesInOnePlaceOrWithoutTrianglesLeaveNoTriangle)
{
  OwnTriangles surface = MakeRandomTriangles(100, 200, 4);
  std::fill(surface.Points.begin(), surface.Points.end(), 3.5F);
  EXPECT_EQ(Thin(surface.GetView(), 16).Points.size(), 1U);
  EXPECT_TRUE(Thin(surface.GetView(), 16).Triangles.empty());
  EXPECT_TRUE(Thin(OwnTriangles().GetView(), 16).Points.empty());
}
