// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace isosurface;

namespace
{

template <typename T>
SpectrumBins Choose(T minimum, T maximum)
{
  return SpectrumBins::Choose(
    ValueTypeOf<T>::Value, { MakeValueKey(minimum), MakeValueKey(maximum) });
}

template <typename T>
void ExpectFits(T minimum, T maximum, std::uint32_t fewest)
{
  const SpectrumBins bins = Choose(minimum, maximum);
  EXPECT_GE(bins.Count, fewest);
  EXPECT_LE(bins.Count, SpectrumBins::MaximumCount);
  const auto low = static_cast<double>(minimum);
  const auto high = static_cast<double>(maximum);
  EXPECT_LE(bins.GetEdge(0), low);
  EXPECT_LE(bins.GetEdge(bins.Count - 1), high);
  if (bins.Count > 1)
  {
    EXPECT_GT(bins.GetEdge(1), low);
  }
  // (2^63 - 1 and 2^64 - 1 as doubles are the next edge itself.)
  const double next = bins.GetEdge(bins.Count);
  EXPECT_TRUE(next > high || std::isinf(next) || (sizeof(T) == 8 && next == high));
}

} // namespace

TEST(SpectrumBins, AreOneValueWideForIntegersOfSmallRange)
{
  const SpectrumBins bytes = Choose<std::uint8_t>(0, 255);
  EXPECT_EQ(bytes.Count, 256u);
  EXPECT_EQ(bytes.Exponent, 0);
  const SpectrumBins scan = Choose<std::int16_t>(-1024, 1023);
  EXPECT_EQ(scan.Count, 2048u);
  EXPECT_EQ(scan.GetEdge(0), -1024);
  const std::int64_t large = std::int64_t{ 1 } << 60;
  EXPECT_EQ(Choose<std::int64_t>(large, large + 9).First, large);
}

TEST(SpectrumBins, CoverTheRangeWithAtLeast1024Bins)
{
  ExpectFits<std::int16_t>(-1024, 1024, 1024);
  ExpectFits<std::uint16_t>(0, 65535, 1024);
  ExpectFits<std::int64_t>(
    std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max(), 1024);
  ExpectFits<std::uint64_t>(0, std::numeric_limits<std::uint64_t>::max(), 1024);
  ExpectFits<float>(-1, 1, 1024);
  ExpectFits<float>(-std::numeric_limits<float>::max(), std::numeric_limits<float>::max(), 1024);
  ExpectFits<double>(-std::numeric_limits<double>::max(), std::numeric_limits<double>::max(), 1024);
  ExpectFits<double>(0, 1e-310, 1024);
  ExpectFits<double>(1e-3, 1.7e7, 1024);
  // Not finer than the spacing of the numbers.
  ExpectFits<float>(1.0f, std::nextafter(1.0f, 2.0f), 2);
  ExpectFits<double>(0, std::numeric_limits<double>::denorm_min(), 2);
}

TEST(SpectrumBins, CoverTheMaximumInteger)
{
  const std::uint64_t maximum = std::numeric_limits<std::uint64_t>::max();
  const SpectrumBins bins = Choose<std::uint64_t>(maximum - 5000, maximum);
  EXPECT_EQ(bins.Exponent, 2);
  EXPECT_EQ(static_cast<std::uint64_t>(bins.First) << 2, (maximum - 5000) / 4 * 4);
  EXPECT_EQ(bins.Count, 1251u);
  EXPECT_EQ(Choose<std::uint64_t>(maximum - 5, maximum).Exponent, 1);
}

TEST(WorkloadSpectrum, AddsSpectraOfEqualBinsOnly)
{
  const SpectrumBins bins = Choose<std::uint8_t>(10, 20);
  WorkloadSpectrum one(bins);
  one.Triangles[3] = 5;
  one.AreaUnit = 0.5;
  WorkloadSpectrum sum(bins);
  ASSERT_TRUE(sum.Add(one));
  ASSERT_TRUE(sum.Add(one));
  EXPECT_EQ(sum.Triangles[3], 10u);
  EXPECT_EQ(sum.AreaUnit, 0.5);

  EXPECT_FALSE(sum.Add(WorkloadSpectrum(Choose<std::uint8_t>(10, 21))));
  one.AreaUnit = 0.25;
  EXPECT_FALSE(sum.Add(one));
  EXPECT_EQ(sum.Triangles[3], 10u);
}

TEST(WorkloadSpectrum, FindsTheBinOfAnIsovalue)
{
  const WorkloadSpectrum spectrum(Choose<std::uint8_t>(10, 20));
  EXPECT_EQ(spectrum.FindBin(-5), 0u);
  EXPECT_EQ(spectrum.FindBin(10), 0u);
  EXPECT_EQ(spectrum.FindBin(13.5), 3u);
  EXPECT_EQ(spectrum.FindBin(14), 4u);
  EXPECT_EQ(spectrum.FindBin(1e9), 10u);
}
