// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/IsovalueProposal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

using namespace isosurface;

namespace
{

struct Histogram
{
  std::vector<double> Values;
  std::vector<double> Counts;

  /// Bins of one width, with peaks of a height and a deviation.
  Histogram(double first, double width, std::size_t bins)
    : Counts(bins)
  {
    for (std::size_t bin = 0; bin < bins; ++bin)
    {
      this->Values.push_back(first + width * static_cast<double>(bin));
    }
  }
  Histogram& Add(double height, double at, double deviation)
  {
    for (std::size_t bin = 0; bin < this->Values.size(); ++bin)
    {
      const double distance = (this->Values[bin] - at) / deviation;
      this->Counts[bin] += std::floor(height * std::exp(-distance * distance / 2));
    }
    return *this;
  }
  std::optional<double> Propose() const { return ProposeIsovalue(this->Values, this->Counts); }
};

} // namespace

TEST(IsovalueProposal, LiesBetweenTwoPeaksAndIsRound)
{
  // Not in the middle of the range, -12: air and tissue of a CT, a little metal.
  const auto ct =
    Histogram(-1024, 1, 2048).Add(9000, -990, 12).Add(4000, 40, 30).Add(5, 900, 50).Propose();
  ASSERT_TRUE(ct);
  EXPECT_GT(*ct, -900);
  EXPECT_LT(*ct, -50);
  EXPECT_EQ(std::fmod(*ct, 10), 0) << *ct;
  // Of floats with a small range.
  const auto density =
    Histogram(-0.05, 1.0 / 8192, 2048).Add(90000, 0, 0.004).Add(3000, 0.15, 0.01).Propose();
  ASSERT_TRUE(density);
  EXPECT_GT(*density, 0.02);
  EXPECT_LT(*density, 0.12);
  EXPECT_EQ(*density, std::round(*density * 1000) / 1000);
}

TEST(IsovalueProposal, IsHalfwayBetweenTheTwoValuesOfAMask)
{
  EXPECT_EQ(ProposeIsovalue({ 0, 1 }, { 900, 100 }), 0.5);
  EXPECT_EQ(ProposeIsovalue({ 0, 100, 200 }, { 900, 0, 1 }), 100);
  EXPECT_EQ(ProposeIsovalue({ 1e9, 1e9 + 1 }, { 5, 5 }), 1e9 + 0.5);
}

TEST(IsovalueProposal, IsNoneOfFewerThanTwoValues)
{
  EXPECT_FALSE(ProposeIsovalue({}, {}));
  EXPECT_FALSE(ProposeIsovalue({ 7 }, { 1000 }));
  EXPECT_FALSE(ProposeIsovalue({ 7, 8, 9 }, { 0, 1000, 0 }));
  EXPECT_FALSE(ProposeIsovalue(WorkloadSpectrum()));
}

TEST(IsovalueProposal, IsWithinTheRangeOfAnyNumbers)
{
  const double large = std::numeric_limits<double>::max();
  const double small = std::numeric_limits<double>::denorm_min();
  for (const std::vector<double>& values : { std::vector<double>{ -large, large }, { 0, small },
         { large / 2, large }, { 0, small, large } })
  {
    const auto isovalue = ProposeIsovalue(values, std::vector<double>(values.size(), 3));
    ASSERT_TRUE(isovalue);
    EXPECT_GE(*isovalue, values.front());
    EXPECT_LE(*isovalue, values.back());
  }
}

TEST(IsovalueProposal, OfAVolumeIsThatOfWhatItLosesFromEdgeToEdge)
{
  SpectrumBins bins;
  bins.First = 10;
  bins.Count = 5; // 10 to 14
  WorkloadSpectrum spectrum(bins);
  spectrum.Volume = { 100, 40, 40, 41, 39 }; // 60 at 10; estimates may grow
  EXPECT_EQ(ProposeIsovalue(spectrum), ProposeIsovalue({ 10, 13, 14 }, { 60, 2, 39 }));
}
