// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/BlockWorkload.h"

#include "Fixtures/SampleVolume.h"
#include "Ground/Volume/BlockGrid.h"
#include "Surface/Contour/MarchingCubesCases.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace isosurface;

namespace
{

template <typename T>
KeyRange FindFiniteRange(const SampleVolume<T>& volume)
{
  KeyRange range;
  for (const T value : volume.Samples)
  {
    if (std::isfinite(static_cast<double>(value)))
    {
      range.Minimum = std::min(range.Minimum, MakeValueKey(value));
      range.Maximum = std::max(range.Maximum, MakeValueKey(value));
    }
  }
  return range;
}

template <typename T>
SpectrumBins ChooseWorkloadBins(const SampleVolume<T>& volume)
{
  return SpectrumBins::Choose(ValueTypeOf<T>::Value, FindFiniteRange(volume));
}

struct Workload
{
  std::uint64_t Triangles = 0;
  std::uint64_t ActiveCells = 0;
};

/// The oracle: classifies every cell at one isovalue.
template <typename T>
Workload CountAt(const SampleVolume<T>& volume, const VertexBox& box, double isovalue)
{
  Workload workload;
  const auto threshold = FindThreshold<T>(isovalue);
  for (std::int64_t k = box.Low[2]; k + 1 < box.High[2]; ++k)
  {
    for (std::int64_t j = box.Low[1]; j + 1 < box.High[1]; ++j)
    {
      for (std::int64_t i = box.Low[0]; i + 1 < box.High[0]; ++i)
      {
        std::size_t inside = 0;
        for (int corner = 0; corner < 8; ++corner)
        {
          const T value = volume.At(i + (corner & 1), j + ((corner >> 1) & 1), k + (corner >> 2));
          inside |= static_cast<std::size_t>(threshold && value >= *threshold) << corner;
        }
        workload.Triangles += MarchingCubesCases[inside] >> 60;
        workload.ActiveCells += inside != 0 && inside != 255;
      }
    }
  }
  return workload;
}

template <typename T>
WorkloadSpectrum CountSpectrum(const SampleVolume<T>& volume, const SpectrumBins& bins)
{
  BlockWorkload workload(bins);
  workload.Count(volume.GetView());
  WorkloadSpectrum spectrum(bins);
  workload.MoveTo(spectrum);
  return spectrum;
}

template <typename T>
void ExpectEqualsBruteForce(const SampleVolume<T>& volume)
{
  const SpectrumBins bins = ChooseWorkloadBins(volume);
  const WorkloadSpectrum spectrum = CountSpectrum(volume, bins);
  const VertexBox box{ { 0, 0, 0 }, volume.GetDimensions() };
  const std::size_t step = bins.Count > 300 ? 7 : 1;
  for (std::size_t bin = 0; bin < bins.Count; bin += step)
  {
    const Workload expected = CountAt(volume, box, bins.GetEdge(bin));
    ASSERT_EQ(spectrum.Triangles[bin], expected.Triangles) << "bin " << bin;
    ASSERT_EQ(spectrum.ActiveCells[bin], expected.ActiveCells) << "bin " << bin;
  }
}

template <typename T>
class BlockWorkloadOfType : public ::testing::Test
{
};
TYPED_TEST_SUITE(BlockWorkloadOfType, AllValueTypes, );

} // namespace

TYPED_TEST(BlockWorkloadOfType, EqualsBruteForceOnNoise)
{
  using T = TypeParam;
  std::mt19937_64 random(7);
  ExpectEqualsBruteForce(SampleVolume<T>({ 11, 9, 10 },
    [&](auto...)
    {
      if constexpr (std::is_floating_point_v<T>)
      {
        return std::normal_distribution<double>(-3, 100)(random);
      }
      else
      {
        return random(); // all bits, the extremes of the type included
      }
    }));
}

TYPED_TEST(BlockWorkloadOfType, EqualsBruteForceOnFewValues)
{
  using T = TypeParam;
  std::mt19937 random(8);
  ExpectEqualsBruteForce(
    SampleVolume<T>({ 12, 10, 9 }, [&](auto...) { return static_cast<int>(random() % 5) + 40; }));
}

TYPED_TEST(BlockWorkloadOfType, EqualsBruteForceOnSmoothValuesInWideRows)
{
  using T = TypeParam;
  ExpectEqualsBruteForce(SampleVolume<T>({ 140, 5, 6 },
    [](auto i, auto j, auto k)
    {
      return 60 +
        55 * std::sin(0.1 * static_cast<double>(i)) * std::cos(0.7 * static_cast<double>(j + k));
    }));
}

TEST(BlockWorkload, CountsNaNAsOutsideAndClipsInfinities)
{
  std::mt19937 random(9);
  ExpectEqualsBruteForce(SampleVolume<float>({ 14, 13, 12 },
    [&](auto...) -> float
    {
      switch (random() % 12)
      {
        case 0:
          return std::numeric_limits<float>::quiet_NaN();
        case 1:
          return std::numeric_limits<float>::infinity();
        case 2:
          return -std::numeric_limits<float>::infinity();
        default:
          return std::uniform_real_distribution<float>(-1, 1)(random);
      }
    }));
}

TEST(BlockWorkload, IsExactForExtremeDoubles)
{
  std::mt19937 random(10);
  for (const double scale : { 1e308, 4e-320, 1e-5, 1e200 })
  {
    ExpectEqualsBruteForce(SampleVolume<double>({ 8, 7, 8 },
      [&](auto...) { return scale * (static_cast<double>(random() % 2001) / 1000 - 1); }));
  }
  // Tiny negative values and large ones: -1e-300 / width underflows, but is below the edge 0.
  ExpectEqualsBruteForce(SampleVolume<double>({ 8, 7, 8 },
    [&](auto...)
    {
      const double values[] = { -1e-300, 1e-300, 1e300, -1e300, 0, -1e-17, -5e297 };
      return values[random() % 7];
    }));
}

TEST(BlockWorkload, CountsTheTrianglesOfEveryCase)
{
  for (unsigned inside = 1; inside < 255; ++inside)
  {
    const SampleVolume<std::uint8_t> cell(
      { 2, 2, 2 }, [&](auto i, auto j, auto k) { return (inside >> (i + 2 * j + 4 * k)) & 1; });
    const WorkloadSpectrum spectrum = CountSpectrum(cell, ChooseWorkloadBins(cell));
    EXPECT_EQ(
      spectrum.Triangles, (std::vector<std::uint64_t>{ 0, MarchingCubesCases[inside] >> 60 }))
      << "case " << inside;
    EXPECT_EQ(spectrum.ActiveCells, (std::vector<std::uint64_t>{ 0, 1 })) << "case " << inside;
  }
}

TEST(BlockWorkload, CountsTheTrianglesOfEveryOrderOfCorners)
{
  // All orders from full to empty, and ties: corners of up to four different values.
  for (unsigned values = 0; values < 65536; ++values)
  {
    const SampleVolume<std::uint8_t> cell(
      { 2, 2, 2 }, [&](auto i, auto j, auto k) { return (values >> 2 * (i + 2 * j + 4 * k)) & 3; });
    const SpectrumBins bins = ChooseWorkloadBins(cell);
    const WorkloadSpectrum spectrum = CountSpectrum(cell, bins);
    for (std::size_t bin = 0; bin < bins.Count; ++bin)
    {
      ASSERT_EQ(spectrum.Triangles[bin],
        CountAt(cell, { { 0, 0, 0 }, cell.GetDimensions() }, bins.GetEdge(bin)).Triangles)
        << "values " << values << ", bin " << bin;
    }
  }
}

TEST(BlockWorkload, CountsMoreCellsThanAPackedSumHolds)
{
  // Layers of two values: each cell between them has two triangles at one isovalue.
  const SampleVolume<std::uint8_t> layers(
    { 300, 300, 220 }, [](auto, auto, auto k) { return k % 2; });
  const WorkloadSpectrum spectrum = CountSpectrum(layers, ChooseWorkloadBins(layers));
  const std::uint64_t cells = 299 * 299 * 219;
  EXPECT_EQ(spectrum.Triangles, (std::vector<std::uint64_t>{ 0, 2 * cells }));
  EXPECT_EQ(spectrum.ActiveCells, (std::vector<std::uint64_t>{ 0, cells }));
}

TEST(BlockWorkload, ResolvesOneUnitInTheLastPlace)
{
  std::mt19937 random(11);
  ExpectEqualsBruteForce(SampleVolume<double>(
    { 6, 6, 6 }, [&](auto...) { return random() % 2 ? 1.0 : std::nextafter(1.0, 2.0); }));
}

TEST(BlockWorkload, TheSumOverBlocksEqualsTheVolume)
{
  std::mt19937 random(12);
  const SampleVolume<std::uint16_t> volume(
    { 50, 37, 33 }, [&](auto i, auto j, auto k) { return 900 + 13 * i + j * k + random() % 50; });
  const SpectrumBins bins = ChooseWorkloadBins(volume);
  const BlockGrid grid(volume.GetDimensions(), 16);
  BlockWorkload workload(bins);
  WorkloadSpectrum sum(bins);
  for (std::int64_t block = 0; block < grid.GetNumberOfBlocks(); ++block)
  {
    workload.Count(volume.GetView(grid.GetVertices(block)));
    workload.MoveTo(sum);
  }
  const WorkloadSpectrum whole = CountSpectrum(volume, bins);
  EXPECT_EQ(sum.Triangles, whole.Triangles);
  EXPECT_EQ(sum.ActiveCells, whole.ActiveCells);
  EXPECT_GT(whole.Triangles[bins.Count / 2], 0u);
}

TEST(BlockWorkload, HonoursStrides)
{
  std::mt19937 random(13);
  const SampleVolume<std::uint8_t> dense({ 20, 9, 8 }, [&](auto...) { return random(); });
  // The same samples at every third byte, with x and z exchanged in memory.
  std::vector<std::uint8_t> scattered(3 * dense.Samples.size());
  SampleView view = dense.GetView();
  view.First = scattered.data();
  view.Stride = { 3 * 8 * 9, 3 * 8, 3 };
  VisitVertices({ { 0, 0, 0 }, { 20, 9, 8 } },
    [&](const Index3& vertex)
    {
      const auto [i, j, k] = vertex;
      scattered[static_cast<std::size_t>(3 * (k + 8 * (j + 9 * i)))] = dense.At(i, j, k);
    });
  const SpectrumBins bins = ChooseWorkloadBins(dense);
  BlockWorkload workload(bins);
  workload.Count(view);
  WorkloadSpectrum spectrum(bins);
  workload.MoveTo(spectrum);
  EXPECT_EQ(spectrum.Triangles, CountSpectrum(dense, bins).Triangles);
}

TEST(BlockWorkload, FlatAndConstantVolumesHaveNoTriangles)
{
  const SampleVolume<float> constant({ 5, 5, 5 }, [](auto...) { return 2.5; });
  const SpectrumBins bins = ChooseWorkloadBins(constant);
  ASSERT_EQ(bins.Count, 1u);
  EXPECT_EQ(bins.GetEdge(0), 2.5);
  EXPECT_EQ(CountSpectrum(constant, bins).Triangles[0], 0u);
  const SampleVolume<float> flat({ 7, 7, 1 }, [](auto i, auto j, auto) { return i * j; });
  const WorkloadSpectrum none = CountSpectrum(flat, ChooseWorkloadBins(flat));
  for (const std::uint64_t triangles : none.Triangles)
  {
    EXPECT_EQ(triangles, 0u);
  }
  const SampleVolume<float> nothing({ 3, 3, 3 }, [](auto...) { return std::nan(""); });
  EXPECT_TRUE(CountSpectrum(nothing, ChooseWorkloadBins(nothing)).Triangles.empty());
}
