// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/Region.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace isosurface;

namespace
{

using Vector = std::array<double, 3>;

double Dot(const Vector& a, const Vector& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Rotated, stretched, mirrored, with an extent that does not begin at 0.
GridGeometry MakeObliqueGrid()
{
  GridGeometry grid;
  grid.Extent = { -4, 45, 7, 36, -20, 9 };
  const double c = std::cos(0.6);
  const double s = std::sin(0.6);
  grid.Direction = { c, -s, 0, s * 0.8, c * 0.8, -0.6, s * 0.6, c * 0.6, 0.8 };
  for (std::size_t row = 0; row < 3; ++row)
  {
    grid.Direction[3 * row] *= -1;
  }
  grid.Spacing = { 0.5, 1.5, 2.0 };
  grid.Origin = { 10, -3, 100 };
  return grid;
}

Vector ToWorld(const GridGeometry& grid, const Vector& structured)
{
  Vector world = grid.Origin;
  for (std::size_t row = 0; row < 3; ++row)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      world[row] += grid.Direction[3 * row + axis] * grid.Spacing[axis] * structured[axis];
    }
  }
  return world;
}

/**
 * The distance between the box and the region: repeatedly projects a point onto one half-space
 * after the other, which converges to a common point if there is one. -1 if that converges too
 * slowly, as between nearly parallel planes.
 */
double FindGap(const GridGeometry& grid, const VertexBox& box, const Region& region)
{
  std::vector<HalfSpace> all = region.GetHalfSpaces();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    // The box's sides in the world; directions are orthonormal.
    const Vector normal{ grid.Direction[axis], grid.Direction[3 + axis], grid.Direction[6 + axis] };
    const double origin = Dot(normal, grid.Origin);
    const auto first = static_cast<double>(grid.Extent[2 * axis]);
    const double low = origin + grid.Spacing[axis] * (first + static_cast<double>(box.Low[axis]));
    const double high =
      origin + grid.Spacing[axis] * (first + static_cast<double>(box.High[axis] - 1));
    all.push_back({ normal, high });
    all.push_back({ { -normal[0], -normal[1], -normal[2] }, -low });
  }
  Vector point = ToWorld(grid,
    { static_cast<double>(grid.Extent[0] + box.Low[0]),
      static_cast<double>(grid.Extent[2] + box.Low[1]),
      static_cast<double>(grid.Extent[4] + box.Low[2]) });
  double gap = 0;
  double gapAtHalfTime = 0;
  for (int round = 0; round < 3000; ++round)
  {
    gapAtHalfTime = round == 1500 ? gap : gapAtHalfTime;
    gap = 0;
    for (const HalfSpace& halfSpace : all)
    {
      const double square = Dot(halfSpace.Normal, halfSpace.Normal);
      const double excess = Dot(halfSpace.Normal, point) - halfSpace.Offset;
      if (excess > 0)
      {
        gap = std::max(gap, excess / std::sqrt(square));
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          point[axis] -= excess / square * halfSpace.Normal[axis];
        }
      }
    }
    if (gap < 1e-9)
    {
      return 0;
    }
  }
  return gap > 0.999 * gapAtHalfTime ? gap : -1;
}

void CheckAllBlocks(const GridGeometry& grid, const Region& region, int& inside, int& outside)
{
  const BlockGrid blocks(grid.GetDimensions(), 16);
  for (std::int64_t block = 0; block < blocks.GetNumberOfBlocks(); ++block)
  {
    const VertexBox box = blocks.GetVertices(block);
    const double gap = FindGap(grid, box, region);
    if (gap == 0)
    {
      ++inside;
      EXPECT_TRUE(region.Intersects(grid, box)) << block;
    }
    else if (gap > 0)
    {
      ++outside;
      EXPECT_FALSE(region.Intersects(grid, box)) << block << ", apart by " << gap;
    }
  }
}

} // namespace

TEST(Region, WithoutHalfSpacesItIsEverything)
{
  EXPECT_TRUE(Region().IsEverything());
  EXPECT_TRUE(Region().Intersects(MakeObliqueGrid(), { { 0, 0, 0 }, { 2, 2, 2 } }));
}

TEST(Region, FindsTheBlocksThatABoxIntersects)
{
  std::mt19937 random(70);
  std::uniform_real_distribution<double> place(-60, 60);
  std::uniform_real_distribution<double> length(0, 40);
  int inside = 0;
  int outside = 0;
  const GridGeometry grid = MakeObliqueGrid();
  const Vector center = ToWorld(grid, { 20, 20, -5 });
  for (int trial = 0; trial < 300; ++trial)
  {
    std::array<double, 6> bounds;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      bounds[2 * axis] = center[axis] + place(random) - 20;
      bounds[2 * axis + 1] = bounds[2 * axis] + length(random);
    }
    CheckAllBlocks(grid, Region::FromBounds(bounds), inside, outside);
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
}

TEST(Region, FindsTheBlocksThatHalfSpacesIntersect)
{
  std::mt19937 random(71);
  std::normal_distribution<double> direction;
  std::uniform_real_distribution<double> distance(-8, 25);
  int inside = 0;
  int outside = 0;
  const GridGeometry grid = MakeObliqueGrid();
  const Vector center = ToWorld(grid, { 20, 20, -5 });
  for (int trial = 0; trial < 300; ++trial)
  {
    std::vector<HalfSpace> halfSpaces(static_cast<std::size_t>(1 + trial % 7));
    for (HalfSpace& halfSpace : halfSpaces)
    {
      halfSpace.Normal = { direction(random), direction(random), direction(random) };
      halfSpace.Offset = Dot(halfSpace.Normal, center) +
        distance(random) * std::sqrt(Dot(halfSpace.Normal, halfSpace.Normal));
    }
    CheckAllBlocks(grid, Region(halfSpaces), inside, outside);
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
}

TEST(Region, IntersectsABlockThatItOnlyTouches)
{
  GridGeometry grid;
  grid.Extent = { 0, 32, 0, 32, 0, 32 };
  const VertexBox box{ { 16, 16, 16 }, { 33, 33, 33 } };
  EXPECT_TRUE(Region::FromBounds({ 0, 16, 0, 16, 0, 16 }).Intersects(grid, box));
  EXPECT_FALSE(Region::FromBounds({ 0, 15.999, 0, 16, 0, 16 }).Intersects(grid, box));
  EXPECT_TRUE(Region::FromBounds({ 20, 20, 20, 20, 20, 20 }).Intersects(grid, box));
}

TEST(Region, BoundsWithAMinimumAboveTheirMaximumAreEmpty)
{
  GridGeometry grid;
  grid.Extent = { 0, 32, 0, 32, 0, 32 };
  const VertexBox box{ { 0, 0, 0 }, { 33, 33, 33 } };
  EXPECT_FALSE(Region::FromBounds({ 1, -1, 1, -1, 1, -1 }).Intersects(grid, box));
  EXPECT_FALSE(Region::FromBounds({ 20, 10, 0, 32, 0, 32 }).Intersects(grid, box));
}

TEST(Region, IntersectionIsWhatBothContain)
{
  GridGeometry grid;
  grid.Extent = { 0, 32, 0, 32, 0, 32 };
  const VertexBox box{ { 0, 0, 0 }, { 33, 33, 33 } };
  const Region low = Region::FromBounds({ 0, 10, 0, 32, 0, 32 });
  const Region high = Region::FromBounds({ 12, 32, 0, 32, 0, 32 });
  EXPECT_TRUE(low.Intersects(grid, box) && high.Intersects(grid, box));
  EXPECT_FALSE(low.Intersect(high).Intersects(grid, box));
}
