// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/GridPlace.h"

#include <gtest/gtest.h>

#include <array>

using namespace isosurface;

namespace
{

TEST(GridPlace, WhatIsNotSetIsTheFilesAndAxesKeepTheirDirections)
{
  GridGeometry grid;
  grid.Spacing = { 1, -2, 3 };
  grid.Origin = { 4, 5, 6 };
  grid.Unit = LengthUnit::Millimeter;
  const GridGeometry found = grid;
  EXPECT_TRUE(GridPlace().Apply("", true, grid).IsOk());
  EXPECT_EQ(grid, found);
  GridPlace place;
  place.Spacing = { 0.5, 0.75, 2 };
  EXPECT_TRUE(place.Apply("", false, grid).IsOk());
  EXPECT_EQ(grid.Spacing, (std::array<double, 3>{ 0.5, -0.75, 2 }));
  EXPECT_EQ(grid.Origin, found.Origin);
  EXPECT_EQ(grid.Unit, found.Unit);
  place.Unit = LengthUnit::Unknown;
  EXPECT_TRUE(place.Apply("", false, grid).IsOk());
  EXPECT_EQ(grid.Unit, LengthUnit::Unknown);
  EXPECT_FALSE(place.Apply("", true, grid).IsOk()) << "a rectilinear grid";
}

TEST(GridPlace, AreasScaleIfAllSpacingsDoAndVolumesAlways)
{
  GridGeometry from;
  from.Spacing = { 0.1, -0.3, 0.7 };
  GridGeometry to = from;
  to.Spacing = { 0.3, 0.9, 2.1 };
  const GridScale scale = GridScale::Find(from, to);
  EXPECT_NEAR(scale.Area, 9, 1e-12);
  EXPECT_NEAR(scale.Volume, 27, 1e-12);
  to.Spacing[0] = 0.6;
  EXPECT_EQ(GridScale::Find(from, to).Area, 0);
  EXPECT_NEAR(GridScale::Find(from, to).Volume, 54, 1e-12);
}

} // namespace
