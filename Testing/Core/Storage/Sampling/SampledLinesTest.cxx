// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/SampledLines.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <set>

using namespace isosurface;

TEST(SampledLines, LinesStayIfAllCornersOfTheirCellAreShownAndPointsIfTheyHaveALine)
{
  constexpr std::int64_t columns = 9;
  constexpr std::int64_t rows = 7;
  std::mt19937 random(11);
  const auto choose = [&](std::int64_t end)
  { return std::uniform_int_distribution<std::int64_t>(0, end - 1)(random); };
  for (int repeat = 0; repeat < 50; ++repeat)
  {
    std::vector<std::uint8_t> isHidden(columns * rows);
    for (std::uint8_t& hidden : isHidden)
    {
      hidden = choose(6) == 0 ? 2 : 0;
    }
    ImageLines lines;
    std::set<std::array<std::array<double, 2>, 2>> expected;
    for (std::int64_t cell = 0; cell < (columns - 1) * (rows - 1); ++cell)
    {
      const std::int64_t i = cell % (columns - 1);
      const std::int64_t j = cell / (columns - 1);
      const bool isNaN = choose(8) == 0;
      const std::array<double, 2> low{ static_cast<double>(i),
        isNaN ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(j) + 0.25 };
      const std::array<double, 2> high{ static_cast<double>(i + 1), static_cast<double>(j) + 0.5 };
      const auto number = static_cast<std::int64_t>(lines.Points.size());
      lines.Points.insert(lines.Points.end(), { low, high });
      lines.Lines.push_back({ number + 1, number });
      bool isShown = !isNaN;
      for (const std::int64_t corner :
        { j * columns + i, j * columns + i + 1, (j + 1) * columns + i, (j + 1) * columns + i + 1 })
      {
        isShown &= isHidden[static_cast<std::size_t>(corner)] == 0;
      }
      if (isShown)
      {
        expected.insert({ high, low });
      }
    }
    const KeptLines kept = KeepSampledLines(lines, columns, rows, isHidden.data());
    std::set<std::array<std::array<double, 2>, 2>> found;
    std::set<std::int64_t> used;
    for (const auto& line : kept.Lines)
    {
      std::array<std::array<double, 2>, 2> ends{};
      for (std::size_t end = 0; end < 2; ++end)
      {
        ends[end] =
          lines.Points[static_cast<std::size_t>(kept.Points[static_cast<std::size_t>(line[end])])];
        used.insert(line[end]);
      }
      found.insert(ends);
    }
    EXPECT_EQ(found, expected);
    EXPECT_EQ(used.size(), kept.Points.size());
  }
}

TEST(SampledLines, WithoutHiddenPointsThoseBesideNaNAloneAreLeftOut)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ImageLines lines{ { { 0, 0.5 }, { 0.5, 0 }, { nan, nan }, { 2, 0.5 }, { 2, 1 } },
    { { 0, 1 }, { 1, 2 }, { 3, 4 } } };
  const KeptLines kept = KeepSampledLines(lines, 3, 2, nullptr);
  EXPECT_EQ(kept.Points, (std::vector<std::int64_t>{ 0, 1, 3, 4 }));
  EXPECT_EQ(kept.Lines, (std::vector<std::array<std::int64_t, 2>>{ { 0, 1 }, { 2, 3 } }));
}
