// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/BlockMeasure.h"

#include "Fixtures/SampleVolume.h"
#include "Ground/Volume/BlockGrid.h"
#include "Surface/Contour/BlockRanges.h"
#include "Surface/Contour/GridBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace isosurface;

namespace
{

constexpr double Pi = 3.14159265358979323846;

GridGeometry MakeGrid(const Index3& size, const std::array<double, 3>& spacing = { 1, 1, 1 })
{
  GridGeometry grid;
  grid.Extent = { 0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1 };
  grid.Spacing = spacing;
  return grid;
}

template <typename T>
SpectrumBins ChooseBins(const SampleVolume<T>& volume)
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
  return SpectrumBins::Choose(ValueTypeOf<T>::Value, range);
}

struct Measures
{
  explicit Measures(WorkloadSpectrum spectrum)
    : Spectrum(std::move(spectrum))
  {
  }
  double GetArea(std::size_t bin) const
  {
    return static_cast<double>(this->Spectrum.Area[bin]) * this->Spectrum.AreaUnit;
  }
  double GetVolume(std::size_t bin) const
  {
    return static_cast<double>(this->Spectrum.Volume[bin]) * this->Spectrum.VolumeUnit;
  }
  WorkloadSpectrum Spectrum;
};

/// Measures the volume by blocks of `side` vertices a side, which overlap by one vertex.
template <typename T>
Measures Measure(const SampleVolume<T>& volume, const GridGeometry& grid, std::int64_t side = 1000,
  std::int64_t rowStride = 1)
{
  const SpectrumBins bins = ChooseBins(volume);
  BlockMeasure measure(bins, grid, rowStride);
  MeasureSums sums(bins);
  for (std::int64_t k = 0; k == 0 || k + 1 < volume.GetDimensions()[2]; k += side)
  {
    for (std::int64_t j = 0; j == 0 || j + 1 < volume.GetDimensions()[1]; j += side)
    {
      for (std::int64_t i = 0; i == 0 || i + 1 < volume.GetDimensions()[0]; i += side)
      {
        const VertexBox box = { { i, j, k },
          { std::min(i + side + 1, volume.GetDimensions()[0]),
            std::min(j + side + 1, volume.GetDimensions()[1]),
            std::min(k + side + 1, volume.GetDimensions()[2]) } };
        measure.Count(volume.GetView(box));
        measure.MoveTo(sums);
      }
    }
  }
  WorkloadSpectrum spectrum(bins);
  spectrum.AreaUnit = BlockMeasure::GetAreaUnit(grid);
  spectrum.VolumeUnit = BlockMeasure::GetVolumeUnit(grid);
  sums.SetMeasures(spectrum);
  return Measures(std::move(spectrum));
}

/// The oracle: the area of the triangles that marching cubes extracts.
template <typename T>
double MeasureTriangles(const SampleVolume<T>& volume, const GridGeometry& grid, double isovalue)
{
  ContourRequest request;
  request.Isovalues = { isovalue };
  const auto ranges = BlockRanges::Compute(volume.GetView(), 1);
  GridBlockSource source(volume.GetView(), *ranges, request.Isovalues);
  const auto surface = ExtractSurface(grid, source, request, 1);
  EXPECT_TRUE(surface.IsOk());
  double area = 0;
  for (std::size_t first = 0; first < surface->Connectivity.GetSize(); first += 3)
  {
    std::array<double, 3> edges[2];
    for (std::size_t edge = 0; edge < 2; ++edge)
    {
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        const auto point = [&](std::size_t corner)
        {
          return static_cast<double>(
            surface->Points[3 * static_cast<std::size_t>(surface->Connectivity[corner]) + axis]);
        };
        edges[edge][axis] = point(first + 1 + edge) - point(first);
      }
    }
    const auto& [u, v] = edges;
    area +=
      std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) /
      2;
  }
  return area;
}

/// Distances from a point within the grid, in world units.
template <typename T>
SampleVolume<T> MakeSphere(const Index3& size, const std::array<double, 3>& spacing, double scale)
{
  return SampleVolume<T>(size,
    [&](auto i, auto j, auto k)
    {
      const double x = spacing[0] * (static_cast<double>(i) - static_cast<double>(size[0]) / 2.1);
      const double y = spacing[1] * (static_cast<double>(j) - static_cast<double>(size[1]) / 1.9);
      const double z = spacing[2] * (static_cast<double>(k) - static_cast<double>(size[2]) / 2.05);
      const double value = 240 - scale * std::hypot(x, y, z);
      return std::is_unsigned_v<T> ? std::max(0.0, value) : value;
    });
}

template <typename T>
void ExpectMeasuresSpheres(const Index3& size, const std::array<double, 3>& spacing, double scale,
  double minimum, double maximum)
{
  const Measures measures = Measure(MakeSphere<T>(size, spacing, scale), MakeGrid(size, spacing));
  const SpectrumBins& bins = measures.Spectrum.Bins;
  int tested = 0;
  for (std::size_t bin = 0; bin < bins.Count; bin += 7)
  {
    const double radius = (240 - bins.GetEdge(bin)) / scale;
    if (radius >= minimum && radius <= maximum)
    {
      ++tested;
      const double area = 4 * Pi * radius * radius;
      const double volume = area * radius / 3;
      // Integers are truncated: their surfaces lie half a value further inside.
      const double shift = std::is_integral_v<T> ? 0.5 / scale * area / volume : 0;
      EXPECT_NEAR(measures.GetArea(bin) / area, 1, 0.03) << "radius " << radius;
      EXPECT_NEAR(measures.GetVolume(bin) / volume, 1 - shift, 0.01) << "radius " << radius;
    }
  }
  EXPECT_GT(tested, 3);
}

} // namespace

TEST(BlockMeasure, MeasuresSpheres)
{
  ExpectMeasuresSpheres<float>({ 100, 99, 101 }, { 1, 1, 1 }, 4, 20, 45);
  ExpectMeasuresSpheres<double>({ 80, 80, 80 }, { 0.01, 0.01, 0.01 }, 400, 0.2, 0.35);
  ExpectMeasuresSpheres<std::int16_t>({ 100, 100, 100 }, { 1, 1, 1 }, 20, 20, 45);
  ExpectMeasuresSpheres<std::uint8_t>({ 100, 100, 100 }, { 1, 1, 1 }, 5, 20, 45);
}

TEST(BlockMeasure, MeasuresSpheresOnGridsOfUnequalSpacing)
{
  ExpectMeasuresSpheres<float>({ 100, 100, 50 }, { 0.7, 0.7, 1.5 }, 5, 15, 30);
  ExpectMeasuresSpheres<float>({ 40, 120, 100 }, { 2.5, 0.8, 1 }, 4, 25, 40);
  ExpectMeasuresSpheres<float>({ 100, 100, 50 }, { -0.7, 0.7, 1.5 }, 5, 15, 30);
}

TEST(BlockMeasure, IsExactForPlanesAcrossAnAxis)
{
  const Index3 size = { 41, 33, 33 };
  const std::array<double, 3> spacing = { 0.5, 2, 1 };
  for (const std::array<double, 3>& gradient :
    { std::array<double, 3>{ 0, 0, 1 }, { 0, 3, 0 }, { -2, 0, 0 } })
  {
    const SampleVolume<float> volume(size,
      [&](auto i, auto j, auto k)
      {
        return gradient[0] * spacing[0] * static_cast<double>(i) +
          gradient[1] * spacing[1] * static_cast<double>(j) +
          gradient[2] * spacing[2] * static_cast<double>(k);
      });
    for (const std::int64_t rowStride : { 1, 2, 4, 8 })
    {
      const Measures measures = Measure(volume, MakeGrid(size, spacing), 1000, rowStride);
      const double box[3] = { 20, 64, 32 };
      const std::size_t axis = gradient[0] != 0 ? 0 : gradient[1] != 0 ? 1 : 2;
      const double area = box[0] * box[1] * box[2] / box[axis];
      const SpectrumBins& bins = measures.Spectrum.Bins;
      for (std::size_t bin = 1; bin + 1 < bins.Count; ++bin)
      {
        ASSERT_NEAR(measures.GetArea(bin) / area, 1, 1e-3) << bin;
        const double inside = gradient[axis] < 0 ? bins.GetEdge(bin) / gradient[axis]
                                                 : box[axis] - bins.GetEdge(bin) / gradient[axis];
        ASSERT_NEAR(measures.GetVolume(bin), area * inside, 1e-3 * area * box[axis]) << bin;
      }
    }
  }
}

TEST(BlockMeasure, MeasuresSpheresInTiltedGrids)
{
  // As a CT's whose gantry is tilted by 30 degrees; and one whose axes have other lengths than 1.
  const std::array<double, 9> tilted = { 1, 0, 0, 0, 1, 0.5, 0, 0, std::sqrt(0.75) };
  const std::array<double, 9> skewed = { 0.9, 0.2, -0.3, 0.1, 1.1, 0.2, 0, 0.3, 0.8 };
  const Index3 size = { 81, 75, 91 };
  for (const std::array<double, 9>& direction : { tilted, skewed })
  {
    for (const double sign : { 1.0, -1.0 })
    {
      GridGeometry grid = MakeGrid(size, { 0.5, sign * 0.7, 0.6 });
      grid.Direction = direction;
      const auto place = [&](auto i, auto j, auto k, std::size_t row)
      {
        return direction[3 * row] * 0.5 * static_cast<double>(i) +
          direction[3 * row + 1] * sign * 0.7 * static_cast<double>(j) +
          direction[3 * row + 2] * 0.6 * static_cast<double>(k);
      };
      const std::array<double, 3> center = { place(40, 37, 45, 0), place(40, 37, 45, 1),
        place(40, 37, 45, 2) };
      const SampleVolume<float> volume(size,
        [&](auto i, auto j, auto k)
        {
          return std::hypot(place(i, j, k, 0) - center[0], place(i, j, k, 1) - center[1],
            place(i, j, k, 2) - center[2]);
        });
      const Measures measures = Measure(volume, grid);
      const SpectrumBins& bins = measures.Spectrum.Bins;
      const double whole = measures.GetVolume(0);
      int tested = 0;
      double areas = 0; // relative to the sphere's
      double volumes = 0;
      for (std::size_t bin = 0; bin < bins.Count; ++bin)
      {
        const double radius = bins.GetEdge(bin);
        if (radius > 6 && radius < 11)
        {
          ++tested;
          const double area = 4 * Pi * radius * radius;
          areas += measures.GetArea(bin) / area;
          volumes += (whole - measures.GetVolume(bin)) / (area * radius / 3);
        }
      }
      ASSERT_GT(tested, 10);
      EXPECT_NEAR(areas / tested, 1, 0.01);
      EXPECT_NEAR(volumes / tested, 1, 0.01);
    }
  }
}

TEST(BlockMeasure, ErrorsGrowWithTheRowStride)
{
  // Planes at angles in step with rows of cells, which a regular choice of rows might miss.
  const Index3 size = { 145, 141, 150 };
  for (const std::array<double, 3>& normal : { std::array<double, 3>{ 0, 1, 1 }, { 0, 1, -1 },
         { 0, 1, 2 }, { 0, 2, 1 }, { 1, 1, 1 }, { 1, 0, 4 }, { 3, 8, 1 } })
  {
    const double length = std::hypot(normal[0], normal[1], normal[2]);
    const SampleVolume<float> volume(size,
      [&](auto i, auto j, auto k)
      {
        return (normal[0] * (static_cast<double>(i) - 72) +
                 normal[1] * (static_cast<double>(j) - 70) +
                 normal[2] * (static_cast<double>(k) - 75)) /
          length;
      });
    const GridGeometry grid = MakeGrid(size);
    const Measures all = Measure(volume, grid);
    const std::size_t bin = all.Spectrum.FindBin(0);
    for (const std::int64_t rowStride : { 2, 4, 8 })
    {
      const Measures few = Measure(volume, grid, 1000, rowStride);
      // On the grids for which these strides are chosen, which are 2 and 4 times as large, the
      // errors are a half and a quarter.
      const double error = 0.015 * static_cast<double>(rowStride);
      EXPECT_NEAR(few.GetArea(bin) / all.GetArea(bin), 1, error) << normal[1] << ' ' << rowStride;
      EXPECT_NEAR(few.GetVolume(bin) / all.GetVolume(bin), 1, 0.01)
        << normal[1] << ' ' << rowStride;
    }
  }
}

TEST(BlockMeasure, MeasuresAllRowsOfSmallGridsAndOneInEightOfLargeOnes)
{
  EXPECT_EQ(BlockMeasure::ChooseRowStride(MakeGrid({ 2, 2, 2 })), 1);
  EXPECT_EQ(BlockMeasure::ChooseRowStride(MakeGrid({ 128, 128, 128 })), 1);
  EXPECT_EQ(BlockMeasure::ChooseRowStride(MakeGrid({ 256, 128, 256 })), 2);
  EXPECT_EQ(BlockMeasure::ChooseRowStride(MakeGrid({ 512, 512, 512 })), 4);
  EXPECT_EQ(BlockMeasure::ChooseRowStride(MakeGrid({ 2048, 2048, 2048 })), 8);
}

TEST(BlockMeasure, AgreesWithTheTrianglesOfSmoothFields)
{
  const Index3 size = { 96, 90, 85 };
  const std::array<double, 3> spacing = { 1, 1.25, 0.8 };
  const SampleVolume<float> volume(size,
    [](auto i, auto j, auto k)
    {
      return 100 * std::sin(0.11 * static_cast<double>(i)) *
        std::cos(0.09 * static_cast<double>(j)) +
        60 * std::sin(0.13 * static_cast<double>(k) + 0.02 * static_cast<double>(i));
    });
  const GridGeometry grid = MakeGrid(size, spacing);
  const Measures measures = Measure(volume, grid);
  const SpectrumBins& bins = measures.Spectrum.Bins;
  for (std::size_t part = 1; part < 8; ++part)
  {
    const std::size_t bin = bins.Count * part / 8;
    const double expected = MeasureTriangles(volume, grid, bins.GetEdge(bin));
    EXPECT_NEAR(measures.GetArea(bin) / expected, 1, 0.03) << bins.GetEdge(bin);
  }
}

TEST(BlockMeasure, StaysNearTheTrianglesOfNoisyFields)
{
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 4);
  const Index3 size = { 90, 90, 90 };
  const SampleVolume<std::uint8_t> volume(size,
    [&](auto i, auto j, auto k)
    {
      const double x = static_cast<double>(i) - 44, y = static_cast<double>(j) - 45,
                   z = static_cast<double>(k) - 46;
      return std::clamp(220 - 4 * std::hypot(x, y, z) + noise(random), 0.0, 255.0);
    });
  const Measures measures = Measure(volume, MakeGrid(size));
  for (const double isovalue : { 60.0, 100.0, 140.0 })
  {
    const std::size_t bin = measures.Spectrum.FindBin(isovalue);
    const double expected = MeasureTriangles(volume, MakeGrid(size), isovalue);
    EXPECT_NEAR(measures.GetArea(bin) / expected, 1, 0.12) << isovalue;
  }
}

TEST(BlockMeasure, SumsOverBlocksEqualTheWhole)
{
  std::mt19937 random(6);
  const SampleVolume<std::uint16_t> volume(
    { 37, 40, 29 }, [&](auto i, auto j, auto k) { return 500 + 13 * i + j * k + random() % 90; });
  const GridGeometry grid = MakeGrid(volume.GetDimensions(), { 1, 2, 3 });
  for (const std::int64_t rowStride : { 1, 2, 4, 8 })
  {
    const Measures whole = Measure(volume, grid, 1000, rowStride);
    for (const std::int64_t side : { 3, 7, 16 })
    {
      const Measures sum = Measure(volume, grid, side, rowStride);
      EXPECT_EQ(sum.Spectrum.Area, whole.Spectrum.Area) << side << ' ' << rowStride;
      EXPECT_EQ(sum.Spectrum.Volume, whole.Spectrum.Volume) << side << ' ' << rowStride;
    }
  }
}

TEST(BlockMeasure, TheVolumeBelowTheMinimumIsThatOfTheGrid)
{
  std::mt19937 random(7);
  // Grids with odd and even numbers of rows, with one row, with one cell.
  for (const Index3& size :
    { Index3{ 9, 8, 7 }, Index3{ 9, 9, 8 }, Index3{ 5, 2, 6 }, Index3{ 2, 2, 2 } })
  {
    const SampleVolume<std::uint8_t> volume(
      size, [&](auto...) { return 10 + static_cast<int>(random() % 200); });
    const auto all = static_cast<double>((size[0] - 1) * (size[1] - 1) * (size[2] - 1));
    for (const std::int64_t rowStride : { 1, 2, 4, 8 })
    {
      const Measures measures = Measure(volume, MakeGrid(size, { 2, 1, 0.5 }), 1000, rowStride);
      EXPECT_NEAR(measures.GetVolume(0), all, 1e-9);
      EXPECT_EQ(measures.GetArea(0), 0);
      for (std::size_t bin = 1; bin < measures.Spectrum.Bins.Count; ++bin)
      {
        EXPECT_LE(measures.GetVolume(bin), measures.GetVolume(bin - 1) + 1e-2);
      }
    }
  }
}

TEST(BlockMeasure, LeavesOutCellsThatAreNotFinite)
{
  const Index3 size = { 6, 6, 6 };
  SampleVolume<float> volume(size, [](auto i, auto, auto) { return i; });
  const Measures before = Measure(volume, MakeGrid(size));
  EXPECT_NEAR(before.GetVolume(0), 125, 1e-9);
  // The corner (5, 4, 5) belongs to two cells.
  for (const float value : { std::numeric_limits<float>::quiet_NaN(),
         std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity() })
  {
    volume.Samples[static_cast<std::size_t>(5 + 6 * (4 + 6 * 5))] = value;
    const Measures after = Measure(volume, MakeGrid(size));
    const double missing = 125 - after.GetVolume(0);
    EXPECT_NEAR(missing, 2, 1e-9);
    for (std::size_t bin = 0; bin < after.Spectrum.Bins.Count; ++bin)
    {
      ASSERT_LE(after.GetVolume(bin), before.GetVolume(bin) + 1e-9);
    }
  }
}

TEST(BlockMeasure, CountUniformEqualsCount)
{
  // A block of a single value next to one of many values.
  const Index3 size = { 17, 9, 9 };
  const SampleVolume<std::int16_t> volume(
    size, [](auto i, auto j, auto) { return i <= 8 ? 70 : 70 + 40 * (i - 8) + j; });
  const GridGeometry grid = MakeGrid(size);
  const SpectrumBins bins = ChooseBins(volume);
  const VertexBox uniform = { { 0, 0, 0 }, { 9, 9, 9 } };
  BlockMeasure measure(bins, grid);
  MeasureSums counted(bins);
  measure.Count(volume.GetView(uniform));
  measure.MoveTo(counted);
  MeasureSums uniformSums(bins);
  measure.CountUniform(ValueType::Int16, MakeValueKey<std::int16_t>(70), uniform);
  measure.CountUniform(ValueType::Int16, NotANumberKey, { { 0, 0, 0 }, { 1, 9, 9 } });
  measure.MoveTo(uniformSums);
  WorkloadSpectrum a(bins);
  WorkloadSpectrum b(bins);
  counted.SetMeasures(a);
  uniformSums.SetMeasures(b);
  EXPECT_EQ(a.Volume, b.Volume);
  EXPECT_GT(a.Volume[0], 0u);
  EXPECT_EQ(a.Volume[1], 0u);
  EXPECT_EQ(a.Area, b.Area);
}
