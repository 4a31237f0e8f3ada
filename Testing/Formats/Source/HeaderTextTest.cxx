// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/HeaderText.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

using namespace isosurface;

using Names = std::vector<std::string>;

TEST(HeaderText, PatternsMakeTheNamesOfASeries)
{
  EXPECT_EQ(
    HeaderText::ExpandPattern("a%d.raw", 8, 12, 2), (Names{ "a8.raw", "a10.raw", "a12.raw" }));
  EXPECT_EQ(HeaderText::ExpandPattern("%03i", 2, 1, -1), (Names{ "002", "001" }));
  EXPECT_EQ(HeaderText::ExpandPattern("a%2u", 9, 10, 3), (Names{ "a 9" }));
  for (const char* pattern : { "a", "a%", "a%s", "a%d%d", "a%1000d" })
  {
    EXPECT_FALSE(HeaderText::ExpandPattern(pattern, 1, 2, 1)) << pattern;
  }
}

TEST(HeaderText, SeriesEndAtTheLargestNumber)
{
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t least = std::numeric_limits<std::int64_t>::min();
  EXPECT_EQ(HeaderText::ExpandPattern("%d", most - 1, most, 1),
    (Names{ "9223372036854775806", "9223372036854775807" }));
  EXPECT_EQ(
    HeaderText::ExpandPattern("%d", 1, most - 1, most - 2), (Names{ "1", "9223372036854775806" }));
  EXPECT_EQ(HeaderText::ExpandPattern("%d", most, 0, least), (Names{ "9223372036854775807" }));
}

TEST(HeaderText, ALongPatternDoesNotMakeManyNames)
{
  constexpr std::int64_t most = std::int64_t{ 1 } << 20;
  EXPECT_EQ(HeaderText::ExpandPattern("a%d", 1, most, 1)->size(), std::size_t{ 1 } << 20);
  EXPECT_FALSE(HeaderText::ExpandPattern("a%d", 0, most, 1));
  EXPECT_FALSE(HeaderText::ExpandPattern(std::string(900000, 'a') + "%d", 1, most, 1));
  EXPECT_EQ(HeaderText::ExpandPattern(std::string(900000, 'a') + "%d", 1, 10, 1)->size(), 10U);
}
