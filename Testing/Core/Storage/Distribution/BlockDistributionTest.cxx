// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Distribution/BlockDistribution.h"

#include "Fixtures/SampleVolume.h"
#include "Ground/Volume/BlockGrid.h"
#include "Storage/Spectrum/BlockWorkload.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

using namespace isosurface;

namespace
{

constexpr DistributionMethod Methods[] = { DistributionMethod::Greedy, DistributionMethod::Random,
  DistributionMethod::Slab, DistributionMethod::Balanced };

std::vector<std::uint64_t> CountBlocks(
  const std::vector<std::uint32_t>& stores, std::uint32_t count)
{
  std::vector<std::uint64_t> blocks(count, 0);
  for (const std::uint32_t store : stores)
  {
    ++blocks.at(store); // throws for a store that does not exist
  }
  return blocks;
}

std::uint64_t FindSpread(const std::vector<std::uint64_t>& counts)
{
  const auto ends = std::minmax_element(counts.begin(), counts.end());
  return *ends.second - *ends.first;
}

std::vector<KeyRange> MakeRandomRanges(std::size_t count)
{
  std::mt19937 random(5);
  std::vector<KeyRange> ranges(count);
  for (KeyRange& range : ranges)
  {
    const float low = std::normal_distribution<float>(0, 10)(random);
    const float size = random() % 4 == 0 ? 0 : std::exponential_distribution<float>(1)(random);
    range = { MakeValueKey(low), MakeValueKey(low + size) };
  }
  return ranges;
}

/// Profiles of blocks whose cubes fill their range.
std::vector<BlockProfile> MakeProfiles(const std::vector<KeyRange>& ranges)
{
  std::mt19937 random(7);
  std::vector<BlockProfile> profiles;
  for (const KeyRange& range : ranges)
  {
    const double low = MakeValueOfKey<float>(range.Minimum);
    const double size = MakeValueOfKey<float>(range.Maximum) - low;
    std::vector<SampleSpan> cubes;
    for (int n = 0; n < 8; ++n)
    {
      const double part = 0.1 * static_cast<double>(random() % 10);
      cubes.push_back({ low + part * size, low + (part + 0.1) * size });
    }
    profiles.push_back(BlockProfile::Make(ValueType::Float32, cubes));
  }
  return profiles;
}

/// A smooth ball with noise in a constant surrounding, so that blocks differ very much.
struct Scene
{
  Scene()
    : Volume({ 129, 129, 129 })
    , Grid(Volume.GetDimensions(), 16)
  {
    std::mt19937 random(6);
    Volume = SampleVolume<std::uint8_t>(Volume.GetDimensions(),
      [&](auto i, auto j, auto k)
      {
        const double x = static_cast<double>(i) / 40 - 1;
        const double y = static_cast<double>(j) / 40 - 1.2;
        const double z = static_cast<double>(k) / 40 - 0.9;
        const double ball = 220 * std::exp(-1.5 * (x * x + y * y + z * z));
        return std::max(0.0, ball - 5) + static_cast<double>(random() % 20);
      });
    for (std::int64_t block = 0; block < Grid.GetNumberOfBlocks(); ++block)
    {
      const SampleView view = Volume.GetView(Grid.GetVertices(block));
      KeyRange range;
      VisitVertices(view.Box,
        [&](const Index3& vertex)
        {
          const ValueKey key = MakeValueKey(Volume.At(vertex));
          range = { std::min(range.Minimum, key), std::max(range.Maximum, key) };
        });
      Ranges.push_back(range);
      WorkloadSpectrum spectrum(Bins);
      BlockWorkload counter(Bins);
      counter.Count(view);
      counter.MoveTo(spectrum);
      Spectra.push_back(spectrum);
      Profiles.push_back(MakeProfile(view.Box));
    }
  }

  BlockProfile MakeProfile(const VertexBox& box) const
  {
    constexpr std::int64_t size = BlockProfile::CubeSize;
    std::vector<SampleSpan> cubes;
    for (std::int64_t cube = 0; cube < 4 * 4 * 4; ++cube)
    {
      SampleSpan span;
      for (std::int64_t n = 0; n < size * size * size; ++n)
      {
        const double value = this->Volume.At(box.Low[0] + cube % 4 * size + n % size,
          box.Low[1] + cube / 4 % 4 * size + n / size % size,
          box.Low[2] + cube / 16 * size + n / (size * size));
        span.Add({ value, value });
      }
      cubes.push_back(span);
    }
    return BlockProfile::Make(ValueType::UInt8, cubes);
  }

  /// The maximum of max/mean of the stores' triangles over all isovalues with a mean of at least
  /// `minimum`.
  double FindImbalance(
    const std::vector<std::uint32_t>& blockStores, std::uint32_t stores, double minimum) const
  {
    double worst = 1;
    for (std::size_t bin = 0; bin < this->Bins.Count; ++bin)
    {
      std::vector<std::uint64_t> triangles(stores, 0);
      std::uint64_t total = 0;
      for (std::size_t block = 0; block < blockStores.size(); ++block)
      {
        triangles[blockStores[block]] += this->Spectra[block].Triangles[bin];
        total += this->Spectra[block].Triangles[bin];
      }
      const double mean = static_cast<double>(total) / stores;
      if (mean >= minimum)
      {
        const std::uint64_t maximum = *std::max_element(triangles.begin(), triangles.end());
        worst = std::max(worst, static_cast<double>(maximum) / mean);
      }
    }
    return worst;
  }

  SampleVolume<std::uint8_t> Volume;
  BlockGrid Grid;
  SpectrumBins Bins{ 0, 0, 256 };
  std::vector<KeyRange> Ranges;
  std::vector<WorkloadSpectrum> Spectra;
  std::vector<BlockProfile> Profiles;
};

} // namespace

TEST(BlockDistribution, GivesEveryBlockOneStore)
{
  const std::vector<KeyRange> ranges = MakeRandomRanges(1000);
  const std::vector<BlockProfile> profiles = MakeProfiles(ranges);
  for (const DistributionMethod method : Methods)
  {
    for (const std::uint32_t stores : { 1u, 2u, 7u, 96u, 1000u, 1024u })
    {
      const auto result = DistributeBlocks(method, ValueType::Float32, ranges, stores, 1, profiles);
      EXPECT_EQ(result.size(), ranges.size());
      const auto counts = CountBlocks(result, stores);
      if (method == DistributionMethod::Greedy || method == DistributionMethod::Slab)
      {
        EXPECT_LE(FindSpread(counts), 1u) << GetDistributionName(method) << ' ' << stores;
      }
    }
    EXPECT_TRUE(DistributeBlocks(method, ValueType::Float32, {}, 3, 1).empty());
  }
}

TEST(BlockDistribution, SpreadsConstantBlocksEvenly)
{
  const std::vector<KeyRange> ranges = MakeRandomRanges(2000);
  const auto result =
    DistributeBlocks(DistributionMethod::Greedy, ValueType::Float32, ranges, 16, 0);
  std::vector<std::uint64_t> constant(16, 0);
  for (std::size_t block = 0; block < ranges.size(); ++block)
  {
    constant[result[block]] += ranges[block].Minimum == ranges[block].Maximum;
  }
  EXPECT_LE(FindSpread(constant), 1u);
}

TEST(BlockDistribution, DealsBlocksOfOneElementByDecreasingRange)
{
  // Of four blocks, the middle two belong to the same element; the larger one is dealt first.
  std::vector<KeyRange> ranges;
  for (const double high : { 1000.0, 10.3, 10.4, 0.0 })
  {
    ranges.push_back({ MakeValueKey(0.0), MakeValueKey(high) });
  }
  const auto result =
    DistributeBlocks(DistributionMethod::Greedy, ValueType::Float64, ranges, 4, 0);
  EXPECT_EQ(result, (std::vector<std::uint32_t>{ 2, 1, 0, 3 }));
}

TEST(BlockDistribution, AcceptsNaNInfinitiesAndExtremeNumbers)
{
  const double infinity = std::numeric_limits<double>::infinity();
  const double maximum = std::numeric_limits<double>::max();
  const std::vector<KeyRange> ranges = { { NotANumberKey, MakeValueKey(3.0) },
    { MakeValueKey(-infinity), MakeValueKey(infinity) }, { NotANumberKey, NotANumberKey },
    { MakeValueKey(-maximum), MakeValueKey(maximum) }, { NotANumberKey, MakeValueKey(infinity) },
    KeyRange{} };
  const auto result =
    DistributeBlocks(DistributionMethod::Greedy, ValueType::Float64, ranges, 3, 0);
  EXPECT_EQ(CountBlocks(result, 3), (std::vector<std::uint64_t>{ 2, 2, 2 }));
  const std::vector<KeyRange> nothing(5, KeyRange{ NotANumberKey, NotANumberKey });
  EXPECT_EQ(
    DistributeBlocks(DistributionMethod::Greedy, ValueType::Float64, nothing, 2, 0).size(), 5u);
}

TEST(BlockDistribution, RandomDependsOnTheSeedOnly)
{
  const std::vector<KeyRange> ranges = MakeRandomRanges(500);
  const auto random = [&](std::uint64_t seed)
  { return DistributeBlocks(DistributionMethod::Random, ValueType::Float32, ranges, 8, seed); };
  EXPECT_EQ(random(1), random(1));
  EXPECT_NE(random(1), random(2));
  // These numbers are in files: they must never change.
  const auto first = random(42);
  EXPECT_EQ(std::vector<std::uint32_t>(first.begin(), first.begin() + 8),
    (std::vector<std::uint32_t>{ 6, 3, 5, 6, 7, 4, 3, 3 }));
}

TEST(BlockDistribution, GreedyAndRandomBalanceTrianglesAndSlabDoesNot)
{
  const Scene scene;
  const auto measure = [&](DistributionMethod method, std::uint32_t stores, double minimum)
  {
    const auto result = DistributeBlocks(method, ValueType::UInt8, scene.Ranges, stores, 1);
    const double imbalance = scene.FindImbalance(result, stores, minimum);
    RecordProperty(GetDistributionName(method) + std::to_string(stores) + "_" +
        std::to_string(static_cast<int>(minimum)),
      std::to_string(imbalance));
    return imbalance;
  };
  // A block of 16^3 cells in the surface has up to 5,000 triangles here: with 1,000 triangles a
  // store no distribution of whole blocks is even.
  for (const double minimum : { 1000.0, 20000.0 })
  {
    const double greedy = measure(DistributionMethod::Greedy, 4, minimum);
    const double random = measure(DistributionMethod::Random, 4, minimum);
    const double slab = measure(DistributionMethod::Slab, 4, minimum);
    EXPECT_LT(greedy, minimum == 1000 ? 2.0 : 1.2);
    EXPECT_LT(random, minimum == 1000 ? 2.5 : 1.5);
    EXPECT_GT(slab, 1.5 * greedy);
    EXPECT_GT(slab, 1.2 * random);
  }
}

TEST(BlockDistribution, BalancedIsMoreEvenThanTheOthers)
{
  const Scene scene;
  for (const std::uint32_t stores : { 4u, 16u })
  {
    const auto measure = [&](DistributionMethod method)
    {
      const auto result =
        DistributeBlocks(method, ValueType::UInt8, scene.Ranges, stores, 1, scene.Profiles);
      return scene.FindImbalance(result, stores, 20000);
    };
    const double balanced = measure(DistributionMethod::Balanced);
    EXPECT_LT(balanced, stores == 4 ? 1.05 : 1.2);
    EXPECT_LT(balanced, measure(DistributionMethod::Greedy));
    EXPECT_LT(balanced, measure(DistributionMethod::Random));
  }
}

TEST(BlockDistribution, BalancedGivesConstantBlocksToStoresWithFewBlocks)
{
  std::vector<BlockProfile> profiles(20);
  profiles[3] = BlockProfile::Make(ValueType::UInt8, { { 0, 100 }, { 0, 50 } });
  profiles[7] = profiles[3];
  const std::vector<KeyRange> ranges(20);
  const auto result =
    DistributeBlocks(DistributionMethod::Balanced, ValueType::UInt8, ranges, 5, 0, profiles);
  EXPECT_EQ(CountBlocks(result, 5), (std::vector<std::uint64_t>{ 4, 4, 4, 4, 4 }));
  EXPECT_NE(result[3], result[7]);
  EXPECT_EQ(CountBlocks(DistributeBlocks(DistributionMethod::Balanced, ValueType::UInt8, ranges, 5,
                          0, std::vector<BlockProfile>(20)),
              5),
    (std::vector<std::uint64_t>{ 4, 4, 4, 4, 4 }));
}

TEST(BlockDistribution, NamesRoundTrip)
{
  for (const DistributionMethod method : Methods)
  {
    EXPECT_EQ(FindDistribution(GetDistributionName(method)), method);
  }
  EXPECT_EQ(GetDistributionName(static_cast<DistributionMethod>(std::size(Methods))), nullptr);
  EXPECT_FALSE(FindDistribution("Greedy").has_value());
}
