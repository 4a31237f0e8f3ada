// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/PointPrecision.h"

#include <gtest/gtest.h>

#include <array>

using namespace isosurface;

namespace
{

GridGeometry MakeGrid(
  const std::array<double, 3>& origin, double spacing, std::int64_t vertices = 32)
{
  GridGeometry grid;
  grid.Extent = { 0, vertices - 1, 0, vertices - 1, 0, vertices - 1 };
  grid.Origin = origin;
  grid.Spacing = { spacing, spacing, spacing };
  return grid;
}

bool NeedsDouble(const GridGeometry& grid)
{
  return NeedsDoublePoints(grid, nullptr);
}

} // namespace

TEST(PointPrecision, IsDoubleWhereFloatHasFewerThan16PlacesBetweenNeighbours)
{
  const std::array<double, 3> map{ 448000, 6000000, -2000 };
  EXPECT_TRUE(NeedsDouble(MakeGrid(map, 0.05)));
  EXPECT_TRUE(NeedsDouble(MakeGrid(map, 1)));
  // From 2^22 on, floats lie half a unit apart.
  EXPECT_TRUE(NeedsDouble(MakeGrid(map, 7.999)));
  EXPECT_FALSE(NeedsDouble(MakeGrid(map, 8)));
  EXPECT_FALSE(NeedsDouble(MakeGrid(map, 12.5)));
  EXPECT_FALSE(NeedsDouble(MakeGrid({ 0, 0, 0 }, 0.05)));
  EXPECT_FALSE(NeedsDouble(MakeGrid({ -250, 250, 1000 }, 0.1)));
  EXPECT_FALSE(NeedsDouble(MakeGrid({ 0, 0, 0 }, 1e-30)));
  EXPECT_FALSE(NeedsDouble(MakeGrid({ 0, 0, 0 }, 1, 1 << 20)));
  EXPECT_TRUE(NeedsDouble(MakeGrid({ 0, 0, 0 }, 1, (1 << 20) + 1)));
  EXPECT_TRUE(NeedsDouble(MakeGrid({ 0, 0, 0 }, 1e300)));
}

TEST(PointPrecision, LooksAtTheAxisOfTheWorldOnWhichNeighboursDiffer)
{
  GridGeometry grid = MakeGrid({ 6000000, 0, 0 }, 12.5);
  grid.Spacing = { 12.5, 0.01, -0.001 };
  EXPECT_FALSE(NeedsDouble(grid));
  grid.Direction = { 0, 1, 0, 1, 0, 0, 0, 0, 1 };
  EXPECT_TRUE(NeedsDouble(grid));
  grid.Spacing = { 0.01, 12.5, 0.001 };
  EXPECT_FALSE(NeedsDouble(grid));
}

TEST(PointPrecision, IsDoubleWhereStructuredCoordinatesAreTooLargeForFloats)
{
  GridGeometry grid = MakeGrid({ -450000, 0, 0 }, 0.05);
  grid.Extent = { 9000000, 9000031, 0, 31, 0, 31 };
  EXPECT_TRUE(NeedsDouble(grid));
}

TEST(PointPrecision, OfLinesIsThatOfTheNearestOnes)
{
  GridLines lines;
  lines.Coordinates = { { { 0, 1e-9, 1, 100 }, { 0, 1 }, { 500, 500.001 } } };
  EXPECT_FALSE(NeedsDoublePoints({}, &lines));
  lines.Coordinates[2] = { 500, 500.0001 };
  EXPECT_TRUE(NeedsDoublePoints({}, &lines));
}
