// SPDX-License-Identifier: BSD-3-Clause
#include "ValueAxis.h"

#include <gtest/gtest.h>

#include <cmath>

using isosurface::ValueAxis;

namespace
{

ValueAxis MakeAxis(double minimum, double maximum, bool integers, double pixels = 200)
{
  ValueAxis axis;
  axis.SetRange(minimum, maximum, integers);
  axis.SetPixels(10, pixels);
  return axis;
}

TEST(ValueAxis, MapsTheRangeToThePixelsAndBack)
{
  const ValueAxis axis = MakeAxis(-1000, 3000, false);
  EXPECT_DOUBLE_EQ(axis.ToPixel(-1000), 10);
  EXPECT_DOUBLE_EQ(axis.ToPixel(3000), 210);
  EXPECT_DOUBLE_EQ(axis.ToPixel(1000), 110);
  EXPECT_NEAR(axis.ToValue(axis.ToPixel(123.4)), 123.4, 1e-9);
}

TEST(ValueAxis, ZoomKeepsTheValueUnderTheMouse)
{
  ValueAxis axis = MakeAxis(0, 100, false);
  const double value = axis.ToValue(160);
  axis.Zoom(160, 5);
  EXPECT_NEAR(axis.ToValue(160), value, 1e-9);
  EXPECT_NEAR(axis.GetMaximum() - axis.GetMinimum(), 20, 1e-9);
  EXPECT_TRUE(axis.IsZoomed());
}

TEST(ValueAxis, NeverLeavesTheFullRange)
{
  ValueAxis axis = MakeAxis(0, 100, false);
  axis.Zoom(10, 10);
  axis.Pan(0, 1000);
  EXPECT_DOUBLE_EQ(axis.GetMinimum(), 0);
  axis.Pan(10000, 0);
  EXPECT_DOUBLE_EQ(axis.GetMaximum(), 100);
  axis.Zoom(10, 1e-6);
  EXPECT_FALSE(axis.IsZoomed());
}

TEST(ValueAxis, ZoomEndsWhereNeighboursAreFarApart)
{
  ValueAxis integers = MakeAxis(0, 65535, true);
  ValueAxis reals = MakeAxis(0, 1, false);
  for (int notch = 0; notch < 500; ++notch)
  {
    integers.Zoom(100, 1.25);
    reals.Zoom(100, 1.25);
  }
  EXPECT_GE(integers.GetMaximum() - integers.GetMinimum(), 4);
  EXPECT_GT(reals.GetMaximum() - reals.GetMinimum(), 1e-10);
}

TEST(ValueAxis, SnapsIntegersToWholeNumbers)
{
  const ValueAxis axis = MakeAxis(-1105, 2008, true);
  EXPECT_EQ(axis.Snap(99.6), 100);
  EXPECT_EQ(axis.Snap(-0.4), 0);
  EXPECT_EQ(axis.Snap(5000), 2008);
}

TEST(ValueAxis, SnapsRealsToFewDigits)
{
  ValueAxis axis = MakeAxis(0, 10, false);
  // A pixel is 0.05 wide: hundredths can be told apart.
  EXPECT_EQ(axis.Snap(1.23456), 1.23);
  axis.Zoom(10, 100);
  EXPECT_EQ(axis.Snap(0.0123456), 0.0123);
}

TEST(ValueAxis, FineStepsAreWholeNumbersOrBelowAPixel)
{
  EXPECT_EQ(MakeAxis(0, 255, true).GetStep(), 1);
  EXPECT_DOUBLE_EQ(MakeAxis(0, 10, false).GetStep(), 0.01);
  const ValueAxis wide = MakeAxis(0, 1e6, true);
  EXPECT_LE(wide.GetStep(), 1e6 / 200);
}

TEST(ValueAxis, ShowsAHandleThatLeavesTheVisibleRange)
{
  ValueAxis axis = MakeAxis(0, 100, false);
  axis.Zoom(10, 10);
  axis.Show(50);
  EXPECT_NEAR(axis.GetMaximum(), 50, 1e-9);
  EXPECT_NEAR(axis.GetMinimum(), 40, 1e-9);
}

TEST(ValueAxis, OneValueGetsARangeAroundIt)
{
  for (const bool integers : { false, true })
  {
    const ValueAxis axis = MakeAxis(7, 7, integers);
    EXPECT_LT(axis.GetMinimum(), 7);
    EXPECT_GT(axis.GetMaximum(), 7);
    EXPECT_NEAR(axis.ToPixel(7), 110, 1e-6);
  }
}

TEST(ValueAxis, TicksAreRoundAndApart)
{
  const ValueAxis axis = MakeAxis(-1105, 2008, true);
  const std::vector<double> ticks = axis.MakeTicks(60);
  ASSERT_GE(ticks.size(), 2U);
  for (std::size_t tick = 0; tick < ticks.size(); ++tick)
  {
    EXPECT_EQ(std::fmod(ticks[tick], 1000), 0);
    EXPECT_TRUE(tick == 0 || axis.ToPixel(ticks[tick]) - axis.ToPixel(ticks[tick - 1]) >= 60);
  }
}

} // namespace
