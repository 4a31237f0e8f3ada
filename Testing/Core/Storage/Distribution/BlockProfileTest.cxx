// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Distribution/BlockProfile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace isosurface;

namespace
{

std::uint32_t CountCubes(const std::vector<SampleSpan>& cubes, double isovalue)
{
  std::uint32_t count = 0;
  for (const SampleSpan& cube : cubes)
  {
    count += cube.Low < isovalue && isovalue <= cube.High ? 1 : 0;
  }
  return count;
}

std::vector<SampleSpan> MakeCubes(std::size_t count, double scale, bool isInteger)
{
  std::mt19937 random(11);
  std::vector<SampleSpan> cubes(count);
  for (SampleSpan& cube : cubes)
  {
    const double low = scale * (static_cast<double>(random() % 1000) - 300);
    const double size = random() % 5 == 0 ? 0 : scale * static_cast<double>(random() % 200);
    cube = isInteger ? SampleSpan{ std::floor(low), std::floor(low + size) }
                     : SampleSpan{ low, low + size };
  }
  return cubes;
}

void ExpectEqual(const BlockProfile& a, const BlockProfile& b)
{
  EXPECT_EQ(a.Span.Low, b.Span.Low);
  EXPECT_EQ(a.Span.High, b.Span.High);
  EXPECT_EQ(a.Exponent, b.Exponent);
  EXPECT_EQ(a.First, b.First);
  EXPECT_EQ(a.Counts, b.Counts);
}

} // namespace

TEST(BlockProfile, CountsTheCubesThatAnIsosurfaceCrosses)
{
  for (const double scale : { 1e-30, 0.013, 1.0, 1e30 })
  {
    const auto cubes = MakeCubes(512, scale, false);
    const BlockProfile profile = BlockProfile::Make(ValueType::Float64, cubes);
    std::size_t nonzero = 0;
    for (std::size_t bin = 0; bin < BlockProfile::MaximumCount; ++bin)
    {
      const double isovalue = std::ldexp(
        static_cast<double>(profile.First + static_cast<std::int64_t>(bin)), profile.Exponent);
      EXPECT_EQ(profile.Counts[bin], CountCubes(cubes, isovalue));
      EXPECT_EQ(profile.GetCount(isovalue), CountCubes(cubes, isovalue));
      EXPECT_EQ(profile.GetCount(isovalue + std::ldexp(0.75, profile.Exponent)),
        CountCubes(cubes, isovalue));
      nonzero += profile.Counts[bin] > 0 ? 1 : 0;
    }
    EXPECT_GE(nonzero, 15u); // not coarser than necessary
    EXPECT_EQ(profile.GetCount(profile.Span.Low - scale * 100), 0u);
    EXPECT_EQ(profile.GetCount(profile.Span.High + scale * 100), 0u);
  }
}

TEST(BlockProfile, HasABinForEveryValueOfSmallIntegerRanges)
{
  const std::vector<SampleSpan> cubes = { { 3, 5 }, { 4, 4 }, { 4, 9 } };
  const BlockProfile profile = BlockProfile::Make(ValueType::UInt8, cubes);
  EXPECT_EQ(profile.Exponent, 0);
  for (int value = 0; value < 20; ++value)
  {
    EXPECT_EQ(profile.GetCount(value), CountCubes(cubes, value)) << value;
  }
}

TEST(BlockProfile, DoesNotDependOnPartsOrTheirOrder)
{
  for (const bool isInteger : { false, true })
  {
    const ValueType type = isInteger ? ValueType::Int16 : ValueType::Float32;
    auto cubes = MakeCubes(300, isInteger ? 1 : 0.37, isInteger);
    cubes.push_back({ 300.1, 300.1001 }); // counted by fine bins only
    cubes.push_back({ -5000, -5000 });    // constant: no isosurface
    const BlockProfile expected = BlockProfile::Make(type, cubes);
    std::mt19937 random(12);
    for (int round = 0; round < 20; ++round)
    {
      std::shuffle(cubes.begin(), cubes.end(), random);
      BlockProfile sum;
      for (std::size_t begin = 0; begin < cubes.size();)
      {
        const std::size_t end = std::min<std::size_t>(cubes.size(), begin + 1 + random() % 40);
        sum.Add(type,
          BlockProfile::Make(type,
            { cubes.begin() + static_cast<std::ptrdiff_t>(begin),
              cubes.begin() + static_cast<std::ptrdiff_t>(end) }));
        begin = end;
      }
      ExpectEqual(sum, expected);
    }
  }
}

TEST(BlockProfile, AcceptsExtremeNumbers)
{
  const double largest = std::numeric_limits<double>::max();
  const double least = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(BlockProfile::Make(ValueType::Float64, { { -largest, largest } }).GetCount(1.0), 1u);
  EXPECT_FALSE(BlockProfile::Make(ValueType::Float64, { { 0, least } }).IsEmpty());
  EXPECT_FALSE(
    BlockProfile::Make(ValueType::Float64, { { 1e18, std::nextafter(1e18, 2e18) } }).IsEmpty());
  EXPECT_TRUE(BlockProfile::Make(ValueType::Float64, { { 7, 7 }, SampleSpan{} }).IsEmpty());
  EXPECT_TRUE(BlockProfile::Make(ValueType::Float64, {}).IsEmpty());
}
