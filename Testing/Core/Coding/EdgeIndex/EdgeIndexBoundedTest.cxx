// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/CodedVolumes.h"
#include "Fixtures/LongTests.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>

using namespace isosurface;

namespace
{

/// The greatest distance of a decoded point from the exact crossing of its edge, in voxels. The
/// geometry must have unit spacing and no origin, so that points are structured coordinates.
template <typename T>
double FindLargestError(const SampleVolume<T>& volume, double isovalue, const Surface& surface)
{
  double largest = 0;
  const Index3 size = volume.GetDimensions();
  for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
  {
    const std::int64_t id = surface.GlobalIds[point];
    const std::int64_t vertex = id / 3;
    const auto axis = static_cast<std::size_t>(id % 3);
    const Index3 from{ vertex % size[0], vertex / size[0] % size[1], vertex / (size[0] * size[1]) };
    Index3 to = from;
    ++to[axis];
    const long double a = volume.At(from[0], from[1], from[2]);
    const long double b = volume.At(to[0], to[1], to[2]);
    for (std::size_t n = 0; n < 3; ++n)
    {
      const long double exact = static_cast<long double>(volume.Geometry.Extent[2 * n] + from[n]) +
        (n == axis ? (static_cast<long double>(isovalue) - a) / (b - a) : 0.0L);
      const auto shift = static_cast<double>(
        std::abs(static_cast<long double>(surface.Points[3 * point + n]) - exact));
      largest = shift > largest || shift != shift ? shift : largest;
    }
  }
  return largest;
}

template <typename T>
void ExpectBounded(const SampleVolume<T>& volume, double isovalue, int blockSize)
{
  TestBlockSource<T> source(volume, blockSize);
  const ContourRequest request = MakeRequest({ isovalue });
  const auto expected = ExtractSurface(volume.Geometry, source, request, 1);
  const auto errors =
    LongTests ? std::vector<double>{ 0.5, 0.1, 0.013, 0.0005 } : std::vector<double>{ 0.5, 0.013 };
  for (const EdgeIndexMode mode : { EdgeIndexMode::Bounded, EdgeIndexMode::Smallest })
  {
    for (const EdgeIndexProfile profile : AllProfiles)
    {
      for (const double error : errors)
      {
        EdgeIndexHeader header = MakeHeader(volume, { isovalue }, mode, profile);
        header.Settings.MaximumError = error;
        const Surface decoded = EncodeAndDecode(header, source, request);
        ExpectSameTopology(*expected, decoded);
        EXPECT_LE(FindLargestError(volume, isovalue, decoded), error);
      }
    }
  }
}

/// Decoded points by their global ids.
template <typename T>
std::map<std::int64_t, std::array<float, 3>> CodePoints(
  const SampleVolume<T>& volume, double isovalue, int blockSize, EdgeIndexProfile profile)
{
  TestBlockSource<T> source(volume, blockSize);
  EdgeIndexHeader header = MakeHeader(volume, { isovalue }, EdgeIndexMode::Bounded, profile);
  header.Settings.MaximumError = 0.09;
  std::map<std::int64_t, std::array<float, 3>> points;
  const auto bytes = EncodeSurface(header, source, 1);
  EXPECT_TRUE(bytes.IsOk()) << bytes.GetStatus().GetMessage();
  const auto decoded = DecodeSurface(bytes->data(), bytes->size(), MakeRequest({ isovalue }), 1);
  EXPECT_TRUE(decoded.IsOk()) << decoded.GetStatus().GetMessage();
  for (std::size_t point = 0; point < decoded->NumberOfPoints; ++point)
  {
    points[decoded->GlobalIds[point]] = { decoded->Points[3 * point],
      decoded->Points[3 * point + 1], decoded->Points[3 * point + 2] };
  }
  return points;
}

} // namespace

TEST(EdgeIndexBounded, PointsOnFacesThatBlocksShareAreThoseInsideOfLargerBlocks)
{
  const auto volume = MakeWaves<std::int16_t>({ 65, 34, 20 }, 0.3);
  for (const EdgeIndexProfile profile : AllProfiles)
  {
    const auto whole = CodePoints(volume, 100.5, 64, profile);
    EXPECT_GT(whole.size(), 1000u);
    for (const int blockSize : { 8, 16, 32 })
    {
      EXPECT_TRUE(CodePoints(volume, 100.5, blockSize, profile) == whole) << blockSize;
    }
  }
}

TEST(EdgeIndexBounded, NoPointIsFurtherFromItsExactCrossingThanTheMaximumError)
{
  auto smooth = MakeWaves<std::int16_t>({ 50, 30, 20 }, 0);
  smooth.Geometry.Extent = { -1000, -951, 2000, 2029, 0, 19 };
  ExpectBounded(smooth, 100.5, 32);
  ExpectBounded(MakeWaves<std::uint8_t>({ 66, 20, 20 }, 3), 127.5, 64);
  ExpectBounded(MakeWaves<float>({ 30, 30, 20 }, 0.3), 0.01, 16);
  ExpectBounded(MakeWaves<double>({ 40, 20, 20 }, 1), 0.01, 32);
}

TEST(EdgeIndexBounded, IntegersOf64BitsAreBoundedUpToThePrecisionOfDoubles)
{
  ExpectBounded(MakeWaves<std::int64_t>({ 30, 30, 30 }, 0.3), 1000.5, 32);
}

TEST(EdgeIndexBounded, CrossingsThatAreNotNumbersStayNaN)
{
  auto volume = MakeWaves<float>({ 30, 30, 30 }, 0.1);
  std::mt19937 random(4);
  for (float& sample : volume.Samples)
  {
    const unsigned drawn = random() % 60;
    sample = drawn == 0 ? std::numeric_limits<float>::quiet_NaN()
      : drawn == 1      ? std::numeric_limits<float>::infinity()
      : drawn == 2      ? -std::numeric_limits<float>::infinity()
                        : sample;
  }
  TestBlockSource<float> source(volume, 16);
  const ContourRequest request = MakeRequest({ 0.1 });
  const auto expected = ExtractSurface(volume.Geometry, source, request, 1);
  for (const EdgeIndexProfile profile : AllProfiles)
  {
    const Surface decoded = EncodeAndDecode(
      MakeHeader(volume, { 0.1 }, EdgeIndexMode::Bounded, profile), source, request);
    ExpectSameTopology(*expected, decoded);
    for (std::size_t n = 0; n < expected->Points.GetSize(); ++n)
    {
      ASSERT_EQ(std::isnan(expected->Points[n]), std::isnan(decoded.Points[n]));
      if (!std::isnan(expected->Points[n]))
      {
        ASSERT_NEAR(expected->Points[n], decoded.Points[n], 0.01001);
      }
    }
  }
}

TEST(EdgeIndexBounded, SmallestIsNotLargerThanEither)
{
  for (const double noise : { 0.0, 2.0 })
  {
    const auto volume = MakeWaves<std::uint8_t>({ 60, 60, 60 }, noise);
    TestBlockSource<std::uint8_t> source(volume, 32);
    EdgeIndexHeader header =
      MakeHeader(volume, { 100.5 }, EdgeIndexMode::Smallest, EdgeIndexProfile::Small);
    for (const double error : { 0.1, 0.001 })
    {
      header.Settings.MaximumError = error;
      std::size_t sizes[3] = {};
      int n = 0;
      for (const EdgeIndexMode mode :
        { EdgeIndexMode::Smallest, EdgeIndexMode::Lossless, EdgeIndexMode::Bounded })
      {
        header.Settings.Mode = mode;
        sizes[n++] = EncodeSurface(header, source, 1)->size();
      }
      // Up to the scale that every record of values has.
      EXPECT_LE(sizes[0], std::min(sizes[1], sizes[2]) + 2 * 8);
    }
  }
}
