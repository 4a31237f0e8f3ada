// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/GrowingSpectrum.h"

#include "Fixtures/SampleVolume.h"
#include "Ground/Volume/BlockGrid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

GridGeometry MakeUnitGrid(const Index3& size)
{
  GridGeometry grid;
  grid.Extent = { 0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1 };
  return grid;
}

/// The spectrum of a volume, block by block in this order.
template <typename T>
WorkloadSpectrum SumBlocks(
  const SampleVolume<T>& volume, const BlockGrid& grid, const std::vector<std::int64_t>& blocks)
{
  BlockSpectrum counter(MeasuredGrid{ MakeUnitGrid(volume.GetDimensions()) });
  const SampleView whole = volume.GetView();
  GrowingSpectrum sum(whole.Type);
  KeyRange finite;
  for (const std::int64_t block : blocks)
  {
    const SampleView samples = volume.GetView(grid.GetVertices(block));
    const SampleRange range = FindSampleRange(samples, samples.Box);
    finite.Add(range.Finite);
    sum.Add(counter.Count(samples, range));
  }
  WorkloadSpectrum spectrum(SpectrumBins::Choose(whole.Type, finite));
  sum.SetSums(spectrum, finite);
  return spectrum;
}

/// Expects area and volume to be about those that are measured in bins known beforehand.
template <typename T>
void ExpectMeasures(const SampleVolume<T>& volume, const WorkloadSpectrum& found)
{
  WorkloadSpectrum expected(found.Bins);
  BlockMeasure measure(found.Bins, MakeUnitGrid(volume.GetDimensions()));
  measure.Count(volume.GetView());
  MeasureSums sums(found.Bins);
  measure.MoveTo(sums);
  sums.SetMeasures(expected);
  const auto cells = static_cast<double>(expected.Volume.front());
  for (std::size_t bin = 0; bin < found.Bins.Count; ++bin)
  {
    EXPECT_NEAR(
      static_cast<double>(found.Area[bin]), static_cast<double>(expected.Area[bin]), 1e-4 * cells);
    EXPECT_NEAR(static_cast<double>(found.Volume[bin]), static_cast<double>(expected.Volume[bin]),
      1e-4 * cells);
  }
}

/// Expects the sum over blocks, in several orders, to be what is counted in bins that were known
/// beforehand; and area and volume, which are rounded, not to depend on the order.
template <typename T>
WorkloadSpectrum ExpectKnowsTheBins(const SampleVolume<T>& volume)
{
  const BlockGrid grid(volume.GetDimensions(), 16);
  std::vector<std::int64_t> blocks(static_cast<std::size_t>(grid.GetNumberOfBlocks()));
  std::iota(blocks.begin(), blocks.end(), 0);
  const WorkloadSpectrum first = SumBlocks(volume, grid, blocks);
  BlockWorkload workload(first.Bins);
  workload.Count(volume.GetView());
  WorkloadSpectrum expected(first.Bins);
  workload.MoveTo(expected);
  EXPECT_GT(first.Bins.Count, 0u);
  EXPECT_EQ(first.Triangles, expected.Triangles);
  EXPECT_EQ(first.ActiveCells, expected.ActiveCells);
  std::mt19937 random(5);
  for (int order = 0; order < 4; ++order)
  {
    std::shuffle(blocks.begin(), blocks.end(), random);
    const WorkloadSpectrum other = SumBlocks(volume, grid, blocks);
    EXPECT_EQ(other.Triangles, first.Triangles);
    EXPECT_EQ(other.ActiveCells, first.ActiveCells);
    EXPECT_EQ(other.Area, first.Area);
    EXPECT_EQ(other.Volume, first.Volume);
  }
  return first;
}

template <typename T>
class GrowingSpectrumOfType : public ::testing::Test
{
};
TYPED_TEST_SUITE(GrowingSpectrumOfType, AllValueTypes, );

} // namespace

TYPED_TEST(GrowingSpectrumOfType, IsThatOfBinsKnownBeforehand)
{
  using T = TypeParam;
  std::mt19937_64 random(3);
  // Ranges of the blocks differ by much; some are of both signs.
  const auto noise = [&](auto i, auto j, auto k)
  {
    const int bits = static_cast<int>((i / 16 * 7 + j / 16 * 3 + k / 16) % (8 * sizeof(T)));
    const auto number = random();
    if constexpr (std::is_floating_point_v<T>)
    {
      const auto value = std::ldexp(static_cast<T>(static_cast<std::int64_t>(number)), bits - 80);
      return static_cast<T>(value);
    }
    else
    {
      using Wide = std::conditional_t<std::is_signed_v<T>, std::int64_t, std::uint64_t>;
      return static_cast<T>(static_cast<Wide>(number) >> (63 - bits));
    }
  };
  ExpectKnowsTheBins(SampleVolume<T>({ 40, 37, 33 }, noise));
  // Cells much narrower than the bins of the volume are measured more exactly in those of the block.
  const SampleVolume<T> smooth({ 40, 20, 18 },
    [](auto i, auto j, auto k) { return static_cast<T>((i * i + 3 * j + k) % 120); });
  ExpectMeasures(smooth, ExpectKnowsTheBins(smooth));
}

TYPED_TEST(GrowingSpectrumOfType, IsKnownUpToTheMaximumOfTheType)
{
  using T = TypeParam;
  for (const int steps : { 1, 3 })
  {
    const SampleVolume<T> volume({ 40, 20, 18 },
      [steps](auto i, auto, auto)
      { return std::numeric_limits<T>::max() - static_cast<T>(i % steps); });
    ExpectMeasures(volume, ExpectKnowsTheBins(volume));
  }
}

TEST(GrowingSpectrum, CountsSurfacesAroundSamplesThatAreNotFinite)
{
  constexpr float infinity = std::numeric_limits<float>::infinity();
  std::mt19937 random(8);
  const float odd[] = { infinity, -infinity, std::nanf("") };
  const auto sample = [&](auto i, auto j, auto k)
  {
    const auto block = i / 16 + 3 * (j / 16) + k / 16;
    // One block has nothing else.
    return block == 4 || random() % 9 == 0 ? odd[random() % 3]
                                           : static_cast<float>(random() % 100 << (2 * block));
  };
  const SampleVolume<float> volume({ 45, 40, 33 }, sample);
  ExpectMeasures(volume, ExpectKnowsTheBins(volume));
}

TEST(GrowingSpectrum, BlocksOfZerosMayComeFirst)
{
  const SampleVolume<float> volume({ 60, 20, 18 },
    [](auto i, auto j, auto k)
    { return i <= 32 ? 0.0F : static_cast<float>((i - 32) * 40 + 3 * j + k) / 8192; });
  ExpectMeasures(volume, ExpectKnowsTheBins(volume));
}
