// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/CrossingIntervals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

using namespace isosurface;

TEST(CrossingIntervals, MiddlesAreWithinHalfAWidthOfAllParameters)
{
  for (const std::uint32_t count : { 1u, 2u, 3u, 6u, 869u })
  {
    const CrossingIntervals intervals = CrossingIntervals::MakeEqual(count);
    for (int n = 0; n <= 10000; ++n)
    {
      const double parameter = n / 10000.0;
      const std::uint32_t found = intervals.Find(parameter);
      ASSERT_LT(found, intervals.GetCount());
      ASSERT_LE(std::abs(intervals.GetMiddle(found) - parameter), 0.5 / count * (1 + 1e-12));
      ASSERT_NEAR(intervals.GetPosition(found), intervals.GetMiddle(found) * 1024, 1);
      const auto fine = static_cast<std::int32_t>(parameter * 65536);
      ASSERT_EQ(intervals.Locate(fine), std::int64_t{ fine } * count);
    }
    EXPECT_EQ(intervals.Find(std::nan("")), intervals.GetCount());
  }
}
