// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/PointSampling.h"
#include "Fixtures/VolumeOnDisk.h"

#include <cmath>
#include <limits>
#include <random>

using namespace isosurface;

namespace
{

/// These points in portions of `size`, each the number of itself.
PointPortions MakeListPortions(const std::vector<std::array<double, 3>>& points, std::size_t size)
{
  PointPortions portions;
  portions.Count = (points.size() + size - 1) / size;
  portions.Give = [&points, size](std::size_t portion, std::vector<SamplePoint>& given)
  {
    given.clear();
    for (std::size_t n = portion * size; n < std::min(points.size(), (portion + 1) * size); ++n)
    {
      given.push_back({ points[n], static_cast<std::int64_t>(n) });
    }
  };
  return portions;
}

std::vector<std::array<double, 3>> MakeRandomPoints(const Index3& size, int count)
{
  std::mt19937 random(11);
  std::vector<std::array<double, 3>> points(static_cast<std::size_t>(count));
  for (auto& point : points)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const auto last = static_cast<double>(size[axis] - 1);
      // Every tenth coordinate is that of a vertex, a few are beyond the grid.
      point[axis] = std::uniform_real_distribution<double>(-0.02 * last, 1.02 * last)(random);
      point[axis] = random() % 10 == 0 ? std::round(point[axis]) : point[axis];
    }
  }
  return points;
}

/// The trilinear value by three steps, axis by axis: another way than that of the code.
template <typename T>
double InterpolateAxisByAxis(
  const SampleVolume<T>& volume, const std::array<double, 3>& point, int level)
{
  const auto along = [&](auto&& self, std::size_t axis, Index3 vertex) -> double
  {
    if (axis == 3)
    {
      return static_cast<double>(
        volume.At(vertex[0] << level, vertex[1] << level, vertex[2] << level));
    }
    const double low = std::floor(point[axis]);
    vertex[axis] = static_cast<std::int64_t>(low);
    const double first = self(self, axis + 1, vertex);
    if (point[axis] == low)
    {
      return first;
    }
    ++vertex[axis];
    return first + (point[axis] - low) * (self(self, axis + 1, vertex) - first);
  };
  return along(along, 0, {});
}

bool IsWithin(const std::array<double, 3>& point, const Index3& size)
{
  bool isWithin = true;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    isWithin &= point[axis] >= 0 && point[axis] <= static_cast<double>(size[axis] - 1);
  }
  return isWithin;
}

/// Samples of the maximum of a type are that between vertices, too.
template <typename T>
void ExpectMaximumBetweenVertices()
{
  constexpr T maximum = std::numeric_limits<T>::max();
  const Index3 size{ 20, 20, 20 };
  MemoryDisk disk;
  const auto written = SampleVolume<T>(size, [](auto, auto, auto) { return maximum; });
  const auto samples =
    Require(LevelSamples::Open(WriteAndOpen(disk, written, MakeSettings(16, 1)), 0, 0));
  const std::vector<std::array<double, 3>> points = { { 10, 10, 10 }, { 10.5, 10, 10 },
    { 3.25, 4.5, 5.75 }, { 18.9, 0.1, 7.3 } };
  std::vector<T> values(points.size());
  std::vector<std::uint8_t> isInside(points.size());
  QueryStatistics statistics;
  ASSERT_TRUE(SamplePoints(*samples, 0, Interpolation::Linear, MakeListPortions(points, 4), 1,
    values.data(), 1, isInside.data(), statistics)
                .IsOk());
  EXPECT_EQ(values, std::vector<T>(points.size(), maximum));
}

} // namespace

TEST(PointSampling, LinearValuesAreThoseOfAllLevels)
{
  const Index3 size{ 70, 33, 50 };
  const auto written = MakeVolume<float>(size);
  MemoryDisk disk;
  const auto volume = WriteAndOpen(disk, written, MakeSettings(16, 3));
  for (int level = 0; level < volume->GetNumberOfLevels(); ++level)
  {
    const auto samples = Require(LevelSamples::Open(volume, 0, level));
    const Index3 dimensions = samples->GetBox().GetSize();
    const auto points = MakeRandomPoints(dimensions, 3000);
    std::vector<float> values(2 * points.size(), -1);
    std::vector<std::uint8_t> isInside(points.size(), 7);
    QueryStatistics statistics;
    const Status status = SamplePoints(*samples, 0, Interpolation::Linear,
      MakeListPortions(points, 100), 2, values.data(), 2, isInside.data(), statistics);
    ASSERT_TRUE(status.IsOk()) << status.GetMessage();
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < points.size(); ++n)
    {
      const bool isWithin = IsWithin(points[n], dimensions);
      wrong += isInside[n] != (isWithin ? 1 : 0);
      const double expected = isWithin ? InterpolateAxisByAxis(written, points[n], level) : -1;
      wrong += std::abs(values[2 * n] - expected) > 1e-5 * (1 + std::abs(expected));
      wrong += values[2 * n + 1] != -1;
    }
    EXPECT_EQ(wrong, 0u) << "level " << level;
  }
}

TEST(PointSampling, NearestValuesAreSamplesAndIntegersAreRounded)
{
  const Index3 size{ 40, 20, 33 };
  const auto written = MakeVolume<std::int16_t>(size);
  MemoryDisk disk;
  const auto samples =
    Require(LevelSamples::Open(WriteAndOpen(disk, written, MakeSettings(16, 2)), 0, 0));
  const auto points = MakeRandomPoints(size, 2000);
  std::vector<std::int16_t> nearest(points.size());
  std::vector<std::int16_t> linear(points.size());
  std::vector<std::uint8_t> isInside(points.size());
  QueryStatistics statistics;
  const PointPortions portions = MakeListPortions(points, 64);
  ASSERT_TRUE(SamplePoints(*samples, 0, Interpolation::Nearest, portions, 2, nearest.data(), 1,
    isInside.data(), statistics)
                .IsOk());
  ASSERT_TRUE(SamplePoints(
    *samples, 0, Interpolation::Linear, portions, 2, linear.data(), 1, isInside.data(), statistics)
                .IsOk());
  for (std::size_t n = 0; n < points.size(); ++n)
  {
    if (isInside[n] == 0)
    {
      continue;
    }
    Index3 vertex{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      vertex[axis] = static_cast<std::int64_t>(std::floor(points[n][axis] + 0.5));
    }
    ASSERT_EQ(nearest[n], written.At(vertex));
    ASSERT_LE(std::abs(linear[n] - InterpolateAxisByAxis(written, points[n], 0)), 0.5 + 1e-9);
  }
}

TEST(PointSampling, AVertexHasItsSampleBesideNanAndBeyondTheBitsOfADouble)
{
  const Index3 size{ 20, 20, 20 };
  auto floats = SampleVolume<double>(size, [](auto, auto, auto) { return std::nan(""); });
  floats.At(10, 10, 10) = 3;
  floats.At(19, 19, 19) = 4;
  const std::vector<std::array<double, 3>> points = { { 10, 10, 10 }, { 19, 19, 19 },
    { 19.0000001, 19, 19 }, { 10.5, 10, 10 }, { std::nan(""), 1, 1 } };
  const PointPortions portions = MakeListPortions(points, 2);
  std::vector<std::uint8_t> isInside(points.size());
  QueryStatistics statistics;
  {
    MemoryDisk disk;
    const auto samples =
      Require(LevelSamples::Open(WriteAndOpen(disk, floats, MakeSettings(16, 1)), 0, 0));
    std::vector<double> values(points.size());
    ASSERT_TRUE(SamplePoints(*samples, 0, Interpolation::Linear, portions, 1, values.data(), 1,
      isInside.data(), statistics)
                  .IsOk());
    EXPECT_EQ(values[0], 3);
    EXPECT_EQ(values[1], 4);
    EXPECT_EQ(values[2], 4) << "beyond the grid by rounding alone";
    EXPECT_TRUE(std::isnan(values[3]));
    EXPECT_EQ(isInside[4], 0) << "a point that is nowhere";
  }
  auto large = SampleVolume<std::int64_t>(size);
  large.At(10, 10, 10) = (std::int64_t{ 1 } << 60) + 1;
  MemoryDisk disk;
  const auto samples =
    Require(LevelSamples::Open(WriteAndOpen(disk, large, MakeSettings(16, 1)), 0, 0));
  std::vector<std::int64_t> values(points.size());
  ASSERT_TRUE(SamplePoints(
    *samples, 0, Interpolation::Linear, portions, 1, values.data(), 1, isInside.data(), statistics)
                .IsOk());
  EXPECT_EQ(values[0], (std::int64_t{ 1 } << 60) + 1);
}

TEST(PointSampling, BetweenSamplesOfTheMaximumOf64BitsIsTheMaximum)
{
  ExpectMaximumBetweenVertices<std::uint64_t>();
  ExpectMaximumBetweenVertices<std::int64_t>();
  EXPECT_EQ(RoundInterpolated<std::int64_t>(-0x1p63), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(RoundInterpolated<std::uint8_t>(254.5), 255);
  EXPECT_EQ(RoundInterpolated<std::int8_t>(-127.5), -128);
}

TEST(PointSampling, TellsOfADamagedBlockAndStopsOnRequest)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, MakeVolume<std::uint8_t>({ 40, 40, 40 }), MakeSettings(16, 1));
  const auto points = MakeRandomPoints({ 40, 40, 40 }, 500);
  std::vector<std::uint8_t> values(points.size());
  std::vector<std::uint8_t> isInside(points.size());
  QueryStatistics statistics;
  const auto sample = [&](const Progress& progress)
  {
    const auto samples = Require(LevelSamples::Open(OpenVolume(disk), 0, 0));
    return SamplePoints(*samples, 0, Interpolation::Linear, MakeListPortions(points, 50), 2,
      values.data(), 1, isInside.data(), statistics, progress);
  };
  EXPECT_EQ(sample([](double) { return false; }).GetCode(), StatusCode::Aborted);
  disk.GetFile(GetStoreFolder(disk, VolumePath, "000001", 0) + "/blocks")[100] ^= 1;
  ExpectError(sample({}), StatusCode::Corrupt, "blocks");
}
