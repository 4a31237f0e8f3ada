// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/CrossingIntervals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

using namespace isosurface;

TEST(CrossingIntervals, MiddlesAreWithinHalfAWidthOfAllParameters)
{
  for (const std::uint32_t width : { 1u << 30, 900000000u, 500000001u, 191260262u, 1234567u })
  {
    const CrossingIntervals intervals = CrossingIntervals::MakeOfWidth(width);
    const double unit = 1 << 30;
    EXPECT_GE(static_cast<double>(intervals.GetCount()) * width, unit);
    EXPECT_LT((static_cast<double>(intervals.GetCount()) - 1) * width, unit);
    for (int n = 0; n <= 10000; ++n)
    {
      const double parameter = n / 10000.0;
      const std::uint32_t found = intervals.Find(parameter);
      ASSERT_LT(found, intervals.GetCount());
      ASSERT_LE(std::abs(intervals.GetMiddle(found) - parameter), width / unit / 2 * (1 + 1e-12));
      ASSERT_NEAR(intervals.GetPosition(found), intervals.GetMiddle(found) * 1024, 1);
      const auto fine = static_cast<std::int32_t>(parameter * 65536);
      ASSERT_NEAR(
        static_cast<double>(intervals.Locate(fine)), fine * unit / width, 1 + unit / width);
    }
    EXPECT_EQ(intervals.Find(std::nan("")), intervals.GetCount());
  }
}
