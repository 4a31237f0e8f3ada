// SPDX-License-Identifier: BSD-3-Clause
#include "SpectrumCurve.h"

#include "CountWords.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <gtest/gtest.h>

using isosurface::SpectrumCurve;
using Quantity = SpectrumCurve::Quantity;

static_assert(
  SpectrumCurve::NumberOfQuantities == isosurface::WorkloadSpectrum::NumberOfQuantities);

namespace
{

SpectrumCurve MakeCurve(bool integers)
{
  SpectrumCurve::Columns columns;
  columns[0] = { 0, 100, 300, 200 }; // triangles
  columns[2] = { 0, 10, 30, 20 };    // blocks
  columns[3] = { 0, 1e3, 3e3, 2e3 }; // bytes
  columns[5] = { 50, 40, 10, 0 };    // volume
  return SpectrumCurve({ 10, 11, 12, 13 }, columns, integers);
}

TEST(SpectrumCurve, IsTheTableAtItsIsovalues)
{
  const SpectrumCurve curve = MakeCurve(false);
  EXPECT_EQ(curve.Evaluate(Quantity::Triangles, 11), 100);
  EXPECT_EQ(curve.Evaluate(Quantity::Triangles, 13), 200);
  EXPECT_EQ(curve.Forecast(12).Blocks, 30);
  EXPECT_EQ(curve.Forecast(12).Bytes, 3000);
}

TEST(SpectrumCurve, IsLinearBetweenThem)
{
  EXPECT_EQ(MakeCurve(false).Evaluate(Quantity::Triangles, 11.25), 150);
}

TEST(SpectrumCurve, OfIntegersChangesAtWholeNumbersOnly)
{
  // Inside is value >= isovalue: of integers 11.25 and 12 are the same.
  EXPECT_EQ(MakeCurve(true).Evaluate(Quantity::Triangles, 11.25), 300);
}

TEST(SpectrumCurve, IsZeroBeyondItsEnds)
{
  const SpectrumCurve curve = MakeCurve(false);
  EXPECT_EQ(curve.Evaluate(Quantity::Triangles, 9.9), 0);
  EXPECT_EQ(curve.Evaluate(Quantity::Triangles, 13.1), 0);
  EXPECT_EQ(SpectrumCurve().Evaluate(Quantity::Triangles, 1), 0);
}

TEST(SpectrumCurve, KnowsWhatItDoesNotKnow)
{
  const SpectrumCurve curve = MakeCurve(false);
  EXPECT_FALSE(curve.Knows(Quantity::Area));
  EXPECT_EQ(curve.Forecast(12).Area, 0);
  EXPECT_TRUE(curve.Knows(Quantity::Triangles));
}

TEST(SpectrumCurve, HistogramIsHowMuchVolumeLiesBetweenIsovalues)
{
  EXPECT_EQ(MakeCurve(false).MakeHistogram(), (std::vector<double>{ 10, 30, 10 }));
  EXPECT_TRUE(SpectrumCurve().MakeHistogram().empty());
}

TEST(SpectrumCurve, SpansDecadesAboveTwoOfThem)
{
  SpectrumCurve::Columns columns;
  columns[0] = { 0, 1, 100 };
  columns[2] = { 0, 1, 101 };
  const SpectrumCurve curve({ 1, 2, 3 }, columns, false);
  EXPECT_FALSE(curve.SpansDecades(Quantity::Triangles));
  EXPECT_TRUE(curve.SpansDecades(Quantity::ActiveBlocks));
}

TEST(CountWords, HaveThreeDigits)
{
  using isosurface::FormatBytes;
  using isosurface::FormatCount;
  using isosurface::FormatSeconds;
  EXPECT_EQ(FormatCount(0), "0");
  EXPECT_EQ(FormatCount(850), "850");
  EXPECT_EQ(FormatCount(12345), "12.3 k");
  EXPECT_EQ(FormatCount(999999), "1.00 M");
  EXPECT_EQ(FormatCount(3.456e9), "3.46 G");
  EXPECT_EQ(FormatBytes(100), "100 B");
  EXPECT_EQ(FormatBytes(1536), "1.50 KiB");
  EXPECT_EQ(FormatBytes(214 * 1024.0 * 1024), "214 MiB");
  EXPECT_EQ(FormatSeconds(0.0034), "3 ms");
  EXPECT_EQ(FormatSeconds(0.26), "0.3 s");
  EXPECT_EQ(FormatSeconds(12.4), "12 s");
  EXPECT_EQ(FormatSeconds(180), "3 min");
}

} // namespace
