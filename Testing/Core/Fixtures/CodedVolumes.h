// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CodedVolumes_h
#define isosurface_CodedVolumes_h

#include "Coding/EdgeIndex/BlockIslands.h"
#include "Coding/EdgeIndex/PreviewBlocks.h"
#include "Fixtures/EdgeIndexStreams.h"
#include "Fixtures/TestBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Islands/IslandKeeping.h"
#include "Surface/Islands/IslandLabels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <type_traits>
#include <vector>

namespace isosurface
{

/// Spheres and waves with some noise, over a good part of the type's range, or -1 to 1.
template <typename T>
SampleVolume<T> MakeWaves(const Index3& dimensions, double noise)
{
  std::mt19937 random(7);
  double scale = 1;
  double middle = 0;
  if (!std::is_floating_point_v<T>)
  {
    scale = 0.4 *
      (std::ldexp(1.0, std::numeric_limits<T>::digits) -
        static_cast<double>(std::numeric_limits<T>::min())) /
      2;
    middle = std::is_signed_v<T> ? 0 : std::ldexp(0.5, std::numeric_limits<T>::digits);
  }
  return SampleVolume<T>(dimensions,
    [&](auto i, auto j, auto k)
    {
      const double x = static_cast<double>(i);
      const double y = static_cast<double>(j);
      const double z = static_cast<double>(k);
      const double wave = std::sin(0.21 * x + 0.1 * y) + std::sin(0.17 * y - 0.05 * z) +
        std::sin(0.23 * z + 0.07 * x) +
        noise * (static_cast<double>(random()) / 4294967296.0 - 0.5);
      return middle + scale * wave / 4;
    });
}

/// The same volume somewhere else in the world.
template <typename T>
void Displace(SampleVolume<T>& volume)
{
  const Index3 size = volume.GetDimensions();
  volume.Geometry.Extent = { -3, size[0] - 4, 5, size[1] + 4, 100, size[2] + 99 };
  volume.Geometry.Origin = { 10, -20, 30.5 };
  volume.Geometry.Spacing = { 0.5, 1.25, 2 };
}

constexpr EdgeIndexProfile AllProfiles[] = { EdgeIndexProfile::Small, EdgeIndexProfile::Working };

template <typename T>
EdgeIndexHeader MakeHeader(const SampleVolume<T>& volume, const std::vector<double>& isovalues,
  EdgeIndexMode mode, EdgeIndexProfile profile)
{
  EdgeIndexHeader header;
  header.Geometry = volume.Geometry;
  header.Type = ValueTypeOf<T>::Value;
  header.Isovalues = isovalues;
  header.Settings.Mode = mode;
  header.Settings.Profile = profile;
  return header;
}

inline ContourRequest MakeRequest(const std::vector<double>& isovalues)
{
  ContourRequest request;
  request.Isovalues = isovalues;
  request.GlobalIds = true;
  return request;
}

template <typename T>
::testing::AssertionResult HaveEqualBytes(const Buffer<T>& a, const Buffer<T>& b)
{
  if (a.GetSize() != b.GetSize())
  {
    return ::testing::AssertionFailure() << a.GetSize() << " and " << b.GetSize() << " values";
  }
  for (std::size_t n = 0; n < a.GetSize(); ++n)
  {
    // Every NaN is the same.
    if (std::memcmp(&a[n], &b[n], sizeof(T)) != 0 && (a[n] == a[n] || b[n] == b[n]))
    {
      return ::testing::AssertionFailure() << "value " << n << " is " << +b[n] << ", not " << +a[n];
    }
  }
  return ::testing::AssertionSuccess();
}

inline void ExpectSameTopology(const Surface& expected, const Surface& decoded)
{
  EXPECT_EQ(expected.NumberOfPoints, decoded.NumberOfPoints);
  EXPECT_EQ(expected.NumberOfTriangles, decoded.NumberOfTriangles);
  EXPECT_TRUE(HaveEqualBytes(expected.GlobalIds, decoded.GlobalIds));
  EXPECT_TRUE(HaveEqualBytes(expected.Connectivity.Values32, decoded.Connectivity.Values32));
  ASSERT_EQ(expected.Parts.size(), decoded.Parts.size());
  for (std::size_t n = 0; n < expected.Parts.size(); ++n)
  {
    EXPECT_EQ(expected.Parts[n].Isovalue, decoded.Parts[n].Isovalue);
    EXPECT_EQ(expected.Parts[n].FirstPoint, decoded.Parts[n].FirstPoint);
    EXPECT_EQ(expected.Parts[n].NumberOfPoints, decoded.Parts[n].NumberOfPoints);
    EXPECT_EQ(expected.Parts[n].FirstCell, decoded.Parts[n].FirstCell);
  }
}

/// The decoded surface must be the extracted one, point by point and bit by bit.
inline void ExpectSamePoints(const Surface& expected, const Surface& decoded)
{
  ExpectSameTopology(expected, decoded);
  EXPECT_TRUE(HaveEqualBytes(expected.Points, decoded.Points));
}

/// Lets a header leave out every n-th island of the surface and of its preview. Returns what is left of the surface.
inline Surface LeaveOutIslands(EdgeIndexHeader& header, BlockSource& source, std::size_t n)
{
  const auto choose = [&](const EdgeIndexHeader& of, BlockSource& blocks,
                        std::shared_ptr<const std::vector<std::int64_t>>& ids)
  {
    Surface surface = Require(ExtractSurface(of.Geometry, blocks, MakeContourRequest(of), 1));
    const IslandLabels labels(surface, 1);
    std::vector<std::uint8_t> areKept(labels.GetNumberOfIslands());
    for (std::size_t island = 0; island < areKept.size(); ++island)
    {
      areKept[island] = island % n != 1 ? 1 : 0;
    }
    KeepIslands(labels, areKept, 1, surface);
    std::vector<std::int64_t> kept(surface.GlobalIds.begin(), surface.GlobalIds.end());
    std::sort(kept.begin(), kept.end());
    ids = std::make_shared<const std::vector<std::int64_t>>(std::move(kept));
    return surface;
  };
  header.LacksIslands = true;
  if (header.PreviewLevel > 0)
  {
    PreviewBlocks preview(source, header.PreviewLevel);
    choose(header.MakePreview(), preview, header.KeptIdsOfPreview);
  }
  return choose(header, source, header.KeptIds);
}

/// What is decoded of a surface that was encoded.
inline Surface EncodeAndDecode(const EdgeIndexHeader& header, BlockSource& source,
  const ContourRequest& request, int threads = 1)
{
  const auto bytes = Require(EncodeSurface(header, source, threads));
  return Require(DecodeSurface(bytes.data(), bytes.size(), request, threads));
}

template <typename T>
void ExpectLossless(const SampleVolume<T>& volume, const std::vector<double>& isovalues,
  int blockSize, EdgeIndexProfile profile)
{
  TestBlockSource<T> source(volume, blockSize);
  EdgeIndexHeader header = MakeHeader(volume, isovalues, EdgeIndexMode::Lossless, profile);
  ContourRequest request = MakeRequest(isovalues);
  ExpectSamePoints(Require(ExtractSurface(volume.Geometry, source, request, 1)),
    EncodeAndDecode(header, source, request));
  // Closed around what is inside, and around what is outside.
  header.ClosedSides = request.ClosedSides = GridSides::All();
  request.DropDegenerateTriangles = true;
  for (const bool isBelow : { false, true })
  {
    header.ClosedSides.AreBeyondInside = request.ClosedSides.AreBeyondInside = isBelow;
    ExpectSamePoints(Require(ExtractSurface(volume.Geometry, source, request, 1)),
      EncodeAndDecode(header, source, MakeRequest({})));
  }
}

} // namespace isosurface

#endif
