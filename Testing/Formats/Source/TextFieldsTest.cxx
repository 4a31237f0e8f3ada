// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/TextFields.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

using namespace isosurface;

using Names = std::vector<std::string>;

TEST(TextFields, PatternsMakeTheNamesOfASeries)
{
  EXPECT_EQ(ExpandPattern("a%d.raw", 8, 12, 2, 3), (Names{ "a8.raw", "a10.raw", "a12.raw" }));
  EXPECT_EQ(ExpandPattern("%03i", 2, 1, -1, 9), (Names{ "002", "001" }));
  EXPECT_EQ(ExpandPattern("a%2u", 9, 10, 3, 9), (Names{ "a 9" }));
  for (const char* pattern : { "a", "a%", "a%s", "a%d%d", "a%1000d" })
  {
    EXPECT_FALSE(ExpandPattern(pattern, 1, 2, 1, 9)) << pattern;
  }
  EXPECT_FALSE(ExpandPattern("a%d.raw", 8, 12, 2, 2)) << "it makes three names";
}

TEST(TextFields, SeriesEndAtTheLargestNumber)
{
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t least = std::numeric_limits<std::int64_t>::min();
  EXPECT_EQ(ExpandPattern("%d", most - 1, most, 1, 2),
    (Names{ "9223372036854775806", "9223372036854775807" }));
  EXPECT_EQ(
    ExpandPattern("%d", 1, most - 1, most - 2, most), (Names{ "1", "9223372036854775806" }));
  EXPECT_EQ(ExpandPattern("%d", most, 0, least, most), (Names{ "9223372036854775807" }));
}

TEST(TextFields, ALongPatternDoesNotMakeManyNames)
{
  constexpr std::int64_t most = std::int64_t{ 1 } << 20;
  EXPECT_EQ(ExpandPattern("a%d", 1, most, 1, 2 * most)->size(), std::size_t{ 1 } << 20);
  EXPECT_FALSE(ExpandPattern("a%d", 0, most, 1, 2 * most));
  EXPECT_FALSE(ExpandPattern(std::string(900000, 'a') + "%d", 1, most, 1, most));
  EXPECT_EQ(ExpandPattern(std::string(900000, 'a') + "%d", 1, 10, 1, most)->size(), 10U);
}
