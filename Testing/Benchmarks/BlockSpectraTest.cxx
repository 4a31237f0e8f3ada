// SPDX-License-Identifier: BSD-3-Clause
#include "Volumes/BlockSpectra.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

using namespace isosurface;

namespace
{

/// Blocks of uint8 values with these triangles at all their isovalues.
BlockSpectra MakeSpectra(const std::vector<std::uint64_t>& triangles)
{
  const SpectrumBins bins{ 0, 0, 8 };
  BlockSpectra spectra(ValueType::UInt8, bins, triangles.size());
  for (std::size_t block = 0; block < triangles.size(); ++block)
  {
    WorkloadSpectrum spectrum(bins);
    std::fill(spectrum.Triangles.begin() + 3, spectrum.Triangles.begin() + 6, triangles[block]);
    // 2 to 5: active at the isovalues 3, 4 and 5.
    spectra.Set(block, spectrum,
      { MakeValueKey(std::uint8_t{ 2 }), MakeValueKey(std::uint8_t{ 5 }) }, 100 + block);
  }
  return spectra;
}

/// The minimum over all distributions of the maximum load, by trying them.
std::uint64_t FindOptimum(
  const std::vector<std::uint64_t>& work, std::vector<std::uint64_t>& loads, std::size_t block)
{
  if (block == work.size())
  {
    return *std::max_element(loads.begin(), loads.end());
  }
  std::uint64_t best = std::numeric_limits<std::uint64_t>::max();
  for (std::uint64_t& load : loads)
  {
    load += work[block];
    best = std::min(best, FindOptimum(work, loads, block + 1));
    load -= work[block];
  }
  return best;
}

} // namespace

TEST(BlockSpectra, AStoresLoadIsTheSumOfItsBlocks)
{
  const StoreLoads loads = MakeSpectra({ 10, 20, 30 }).Distribute({ 1, 0, 1 }, 3);
  ASSERT_EQ(loads.Stores.size(), 3u);
  for (std::size_t bin = 0; bin < 8; ++bin)
  {
    const bool isActive = bin >= 3 && bin <= 5;
    EXPECT_EQ(loads.Stores[0][bin].Triangles, isActive ? 20u : 0u) << bin;
    EXPECT_EQ(loads.Stores[1][bin].Triangles, isActive ? 40u : 0u) << bin;
    EXPECT_EQ(loads.Stores[1][bin].ActiveBlocks, isActive ? 2u : 0u) << bin;
    EXPECT_EQ(loads.Stores[1][bin].Bytes, isActive ? 202u : 0u) << bin;
    EXPECT_EQ(loads.Stores[2][bin].ActiveBlocks, 0u);
    EXPECT_EQ(loads.GetTotal(bin).Triangles, isActive ? 60u : 0u);
    EXPECT_EQ(loads.GetMaximum(bin).Triangles, isActive ? 40u : 0u);
  }
}

TEST(BlockSpectra, NoDistributionHasAMaximumBelowTheBound)
{
  std::mt19937 random(4);
  int tight = 0;
  for (int round = 0; round < 200; ++round)
  {
    std::vector<std::uint64_t> work(1 + random() % 7);
    for (std::uint64_t& block : work)
    {
      block = 1 + random() % (round % 2 == 0 ? 10 : 1000);
    }
    const std::uint32_t stores = 1 + random() % 4;
    std::vector<std::uint64_t> loads(stores, 0);
    const std::uint64_t optimum = FindOptimum(work, loads, 0);
    const std::uint64_t bound = MakeSpectra(work).GetMaximumBound(4, stores);
    EXPECT_LE(bound, optimum);
    tight += bound == optimum ? 1 : 0;
  }
  EXPECT_GT(tight, 100);
  EXPECT_EQ(MakeSpectra({ 5, 7 }).GetMaximumBound(0, 2), 0u);
}
