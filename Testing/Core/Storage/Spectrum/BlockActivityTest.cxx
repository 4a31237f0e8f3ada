// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/BlockActivity.h"

#include "Fixtures/SampleVolume.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

template <typename T>
struct Block
{
  T Minimum;
  T Maximum;
  std::uint64_t Bytes;
};

/// Compares with the ranges of all blocks, at every edge.
template <typename T>
void ExpectEqualsBruteForce(const std::vector<Block<T>>& blocks)
{
  KeyRange all;
  for (const Block<T>& block : blocks)
  {
    all.Minimum = std::min(all.Minimum, MakeValueKey(block.Minimum));
    all.Maximum = std::max(all.Maximum, MakeValueKey(block.Maximum));
  }
  const ValueType type = ValueTypeOf<T>::Value;
  const SpectrumBins bins = SpectrumBins::Choose(type, all);
  BlockActivity activity(type, bins);
  for (const Block<T>& block : blocks)
  {
    activity.Add({ MakeValueKey(block.Minimum), MakeValueKey(block.Maximum) }, block.Bytes);
  }
  WorkloadSpectrum spectrum(bins);
  activity.SetActivity(spectrum);
  for (std::size_t bin = 0; bin < bins.Count; ++bin)
  {
    // Exact for all types: every edge of integers fits in 128 bits.
    const auto isBelow = [&](T value)
    {
      if constexpr (std::is_integral_v<T>)
      {
        const __int128 multiple = static_cast<__int128>(bins.First) + static_cast<__int128>(bin);
        return static_cast<__int128>(value) <
          multiple * (static_cast<__int128>(1) << bins.Exponent);
      }
      else
      {
        return value < bins.GetEdge(bin);
      }
    };
    std::uint64_t count = 0;
    std::uint64_t bytes = 0;
    for (const Block<T>& block : blocks)
    {
      const bool isActive = isBelow(block.Minimum) && !isBelow(block.Maximum);
      count += isActive ? 1 : 0;
      bytes += isActive ? block.Bytes : 0;
    }
    ASSERT_EQ(spectrum.ActiveBlocks[bin], count) << "bin " << bin;
    ASSERT_EQ(spectrum.Bytes[bin], bytes) << "bin " << bin;
  }
}

template <typename T>
class BlockActivityOfType : public ::testing::Test
{
};
TYPED_TEST_SUITE(BlockActivityOfType, AllValueTypes, );

template <typename T>
std::vector<Block<T>> MakeBlocks(T origin, std::uint64_t spread)
{
  std::mt19937_64 random(3);
  std::vector<Block<T>> blocks;
  for (int index = 0; index < 60; ++index)
  {
    const auto a = static_cast<T>(origin + static_cast<T>(random() % spread));
    const auto b = static_cast<T>(origin + static_cast<T>(random() % spread));
    blocks.push_back({ std::min(a, b), index % 10 == 0 ? std::min(a, b) : std::max(a, b),
      std::uint64_t{ 1 } << (index % 40) });
  }
  return blocks;
}

} // namespace

TYPED_TEST(BlockActivityOfType, EqualsBruteForceAtEveryEdge)
{
  using T = TypeParam;
  ExpectEqualsBruteForce(MakeBlocks<T>(std::is_signed_v<T> ? T(-60) : T(0), 120));
  if constexpr (sizeof(T) > 1)
  {
    ExpectEqualsBruteForce(MakeBlocks<T>(std::is_signed_v<T> ? T(-9000) : T(7), 20000));
  }
}

TEST(BlockActivity, IsExactForIntegersThatRoundToTheSameDouble)
{
  ExpectEqualsBruteForce(MakeBlocks<std::int64_t>((std::int64_t{ 1 } << 60) + 1, 100));
  ExpectEqualsBruteForce(
    MakeBlocks<std::uint64_t>(std::numeric_limits<std::uint64_t>::max() - 5000, 4000));
  ExpectEqualsBruteForce(
    MakeBlocks<std::int64_t>(std::numeric_limits<std::int64_t>::min(), std::uint64_t{ 1 } << 62));
}

TEST(BlockActivity, NaNIsBelowAllEdgesAndInfinitiesAreBeyondThem)
{
  const SpectrumBins bins =
    SpectrumBins::Choose(ValueType::Float32, { MakeValueKey(-1.0f), MakeValueKey(1.0f) });
  BlockActivity activity(ValueType::Float32, bins);
  const float infinity = std::numeric_limits<float>::infinity();
  activity.Add({ NotANumberKey, MakeValueKey(1.0f) }, 10);
  activity.Add({ MakeValueKey(-infinity), MakeValueKey(infinity) }, 100);
  activity.Add({ NotANumberKey, NotANumberKey }, 1000);
  activity.Add(KeyRange(), 10000);
  WorkloadSpectrum spectrum(bins);
  activity.SetActivity(spectrum);
  for (std::size_t bin = 0; bin < bins.Count; ++bin)
  {
    EXPECT_EQ(spectrum.ActiveBlocks[bin], 2u);
    EXPECT_EQ(spectrum.Bytes[bin], 110u);
  }
}
