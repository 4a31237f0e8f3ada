// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/CodedVolumes.h"
#include "Surface/Contour/TriangleNormals.h"

#include "Fixtures/PlainContour.h"

#include <gtest/gtest.h>

using namespace isosurface;

namespace
{

template <typename T>
class EdgeIndexOfType : public ::testing::Test
{
};

TYPED_TEST_SUITE(EdgeIndexOfType, AllValueTypes);

template <typename T>
double FindMiddle()
{
  return std::is_floating_point_v<T> || std::is_signed_v<T>
    ? 0.1
    : std::ldexp(0.5, std::numeric_limits<T>::digits) + 0.5;
}

template <typename T>
void FillWithExtremes(SampleVolume<T>& volume)
{
  std::mt19937 random(11);
  for (T& sample : volume.Samples)
  {
    const unsigned drawn = random() % 8;
    sample = drawn == 0 ? std::numeric_limits<T>::max()
      : drawn == 1      ? std::numeric_limits<T>::lowest()
      : drawn == 2      ? T(0)
                        : static_cast<T>(random() % 100);
    if constexpr (std::is_floating_point_v<T>)
    {
      sample = drawn == 3 ? std::numeric_limits<T>::quiet_NaN()
        : drawn == 4      ? std::numeric_limits<T>::infinity()
        : drawn == 5      ? -std::numeric_limits<T>::infinity()
        : drawn == 6      ? -T(0)
        : drawn == 7      ? std::numeric_limits<T>::denorm_min()
                          : sample;
    }
  }
}

} // namespace

TYPED_TEST(EdgeIndexOfType, SmoothVolumesComeBackBitByBit)
{
  SampleVolume<TypeParam> volume = MakeWaves<TypeParam>({ 70, 21, 17 }, 0);
  Displace(volume);
  for (const EdgeIndexProfile profile : AllProfiles)
  {
    ExpectLossless(volume, { FindMiddle<TypeParam>() }, 32, profile);
  }
}

TYPED_TEST(EdgeIndexOfType, NoiseComesBackBitByBit)
{
  const SampleVolume<TypeParam> volume = MakeWaves<TypeParam>({ 35, 20, 18 }, 3);
  for (const EdgeIndexProfile profile : AllProfiles)
  {
    ExpectLossless(volume, { FindMiddle<TypeParam>() }, 64, profile);
  }
}

TYPED_TEST(EdgeIndexOfType, ExtremesComeBackBitByBit)
{
  SampleVolume<TypeParam> volume({ 19, 18, 17 });
  FillWithExtremes(volume);
  for (const double isovalue : { 0.0, 50.0, -1e300, 1e300 })
  {
    for (const EdgeIndexProfile profile : AllProfiles)
    {
      ExpectLossless(volume, { isovalue }, 16, profile);
    }
  }
}

TYPED_TEST(EdgeIndexOfType, FewLevelsAndValuesOnTheIsovalueComeBackBitByBit)
{
  std::mt19937 random(2);
  const auto volume = MakeRandomVolume<TypeParam>(random, { 33, 18, 35 }, 4);
  ExpectLossless(volume, { 1.0 }, 16, EdgeIndexProfile::Small);
  ExpectLossless(volume, { 1.0 }, 32, EdgeIndexProfile::Working);
}

TEST(EdgeIndex, EveryBlockSizeGivesTheExtractedSurface)
{
  const auto volume = MakeWaves<std::uint8_t>({ 131, 35, 34 }, 0.2);
  for (const int blockSize : { 16, 32, 64 })
  {
    for (const EdgeIndexProfile profile : AllProfiles)
    {
      ExpectLossless(volume, { 120.5 }, blockSize, profile);
    }
  }
}

TEST(EdgeIndex, TheDecodedSurfaceIsThatOfPlainMarchingCubes)
{
  const auto volume = MakeWaves<std::int16_t>({ 40, 36, 21 }, 0.1);
  TestBlockSource<std::int16_t> source(volume, 16);
  const Surface decoded =
    EncodeAndDecode(MakeHeader(volume, { 99.5 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Small),
      source, MakeRequest({}));
  PlainSurface plain = ContourPlainly(volume, { 99.5 });
  for (auto& point : plain.Points)
  {
    std::fill(point.second.begin() + 3, point.second.end(), 0); // normals
  }
  EXPECT_TRUE(plain == MakePlain(decoded));
}

TEST(EdgeIndex, CheckerboardsAndSingleCellsAreEqualAfterDecoding)
{
  for (const Index3& size : { Index3{ 2, 2, 2 }, Index3{ 17, 2, 5 }, Index3{ 66, 33, 34 } })
  {
    const SampleVolume<std::uint8_t> volume(
      size, [](auto i, auto j, auto k) { return (i + j + k) % 2 != 0 ? 255 : 0; });
    for (const EdgeIndexProfile profile : AllProfiles)
    {
      ExpectLossless(volume, { 127.5 }, 64, profile);
      ExpectLossless(volume, { 127.5 }, 16, profile);
    }
  }
}

TEST(EdgeIndex, AnEmptySurfaceIsAHeaderOnly)
{
  const SampleVolume<float> volume({ 20, 20, 20 });
  TestBlockSource<float> source(volume, 16);
  const EdgeIndexHeader header =
    MakeHeader(volume, { 1.0 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
  const auto bytes = EncodeSurface(header, source, 1);
  std::vector<std::uint8_t> expected;
  header.Append(expected);
  ASSERT_TRUE(bytes.IsOk());
  EXPECT_EQ(*bytes, expected);
  const auto decoded = Require(DecodeSurface(bytes->data(), bytes->size(), MakeRequest({}), 1));
  EXPECT_EQ(decoded.NumberOfPoints, 0u);
}

TEST(EdgeIndex, SeveralIsovaluesBecomeTheExtractorsParts)
{
  const auto volume = MakeWaves<std::uint16_t>({ 60, 40, 30 }, 0.1);
  ExpectLossless(volume, { 30000.5, 33000.25, 64000, 35000 }, 32, EdgeIndexProfile::Small);
}

TEST(EdgeIndex, WideIndicesOfSeveralIsovaluesEqualNarrowOnes)
{
  const auto volume = MakeWaves<std::uint16_t>({ 40, 30, 20 }, 0.1);
  const std::vector<double> isovalues = { 30000.5, 33000.25, 35000 };
  TestBlockSource<std::uint16_t> source(volume, 16);
  const auto bytes = Require(EncodeSurface(
    MakeHeader(volume, isovalues, EdgeIndexMode::Lossless, EdgeIndexProfile::Working), source, 1));
  ContourRequest request = MakeRequest(isovalues);
  request.Offsets = true;
  Result<Surface> narrow = DecodeSurface(bytes.data(), bytes.size(), request, 1);
  request.WideIndices = true;
  Result<Surface> wide = DecodeSurface(bytes.data(), bytes.size(), request, 1);
  ASSERT_TRUE(narrow.IsOk() && wide.IsOk());
  EXPECT_TRUE(wide->Connectivity.Is64Bit && wide->Offsets.Is64Bit);
  ASSERT_EQ(wide->Connectivity.GetSize(), narrow->Connectivity.GetSize());
  ASSERT_EQ(wide->Offsets.GetSize(), narrow->NumberOfCells + 1);
  for (std::size_t n = 0; n < wide->Connectivity.GetSize(); ++n)
  {
    ASSERT_EQ(wide->Connectivity[n], narrow->Connectivity[n]);
  }
  for (std::size_t n = 0; n <= wide->NumberOfCells; ++n)
  {
    ASSERT_EQ(wide->Offsets[n], 3 * static_cast<std::int64_t>(n));
    ASSERT_EQ(narrow->Offsets[n], 3 * static_cast<std::int64_t>(n));
  }
  ComputeNormalsOfTriangles(*narrow);
  ComputeNormalsOfTriangles(*wide);
  EXPECT_TRUE(HaveEqualBytes(wide->Normals, narrow->Normals));
}

TEST(EdgeIndex, LeavingOutBlocksDoesNotChangeTheOthers)
{
  const auto volume = MakeWaves<std::uint8_t>({ 64, 48, 40 }, 0.2);
  TestBlockSource<std::uint8_t> source(volume, 16);
  source.Blocks = { 17, 3, 0, 22, 8, 9 };
  const ContourRequest request = MakeRequest({ 120.5 });
  const auto expected = ExtractSurface(volume.Geometry, source, request, 1);
  const Surface decoded = EncodeAndDecode(
    MakeHeader(volume, { 120.5 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Working), source,
    request);
  ExpectSamePoints(*expected, decoded);
}

TEST(EdgeIndex, ThreadsChangeNeitherBytesNorSurface)
{
  const auto volume = MakeWaves<std::int16_t>({ 100, 40, 35 }, 0.2);
  TestBlockSource<std::int16_t> source(volume, 32);
  const EdgeIndexHeader header =
    MakeHeader(volume, { 10.5, 4000 }, EdgeIndexMode::Smallest, EdgeIndexProfile::Small);
  const auto one = EncodeSurface(header, source, 1);
  const auto four = EncodeSurface(header, source, 4);
  ASSERT_TRUE(one.IsOk() && four.IsOk());
  EXPECT_EQ(*one, *four);
  const auto first = DecodeSurface(one->data(), one->size(), MakeRequest({}), 1);
  const auto second = DecodeSurface(one->data(), one->size(), MakeRequest({}), 4);
  ASSERT_TRUE(first.IsOk() && second.IsOk());
  ExpectSamePoints(*first, *second);
}

namespace
{

// What is decoded of a surface whose samples, from -1 to 1, were quantized. Its topology is kept.
Surface QuantizeSurface(EdgeIndexHeader header, int bits, BlockSource& source,
  const ContourRequest& request, const Surface& expected)
{
  header.Settings.QuantizationBits = bits;
  header.Settings.QuantizationMinimum = -1;
  header.Settings.QuantizationMaximum = 1;
  Surface decoded = EncodeAndDecode(header, source, request);
  ExpectSameTopology(expected, decoded);
  return decoded;
}

} // namespace

TEST(EdgeIndex, QuantizedValuesKeepTheTopologyAndConverge)
{
  const auto volume = MakeWaves<float>({ 50, 40, 30 }, 0.1);
  TestBlockSource<float> source(volume, 32);
  const ContourRequest request = MakeRequest({ 0.05 });
  const auto expected = ExtractSurface(volume.Geometry, source, request, 1);
  double last = 1;
  for (const int bits : { 2, 6, 12, 20 })
  {
    for (const EdgeIndexProfile profile : AllProfiles)
    {
      const EdgeIndexHeader header =
        MakeHeader(volume, { 0.05 }, EdgeIndexMode::Quantized, profile);
      const Surface decoded = QuantizeSurface(header, bits, source, request, *expected);
      double sum = 0;
      for (std::size_t n = 0; n < expected->Points.GetSize(); ++n)
      {
        sum += std::abs(static_cast<double>(expected->Points[n] - decoded.Points[n]));
      }
      sum /= static_cast<double>(expected->NumberOfPoints);
      EXPECT_LT(sum, last) << bits;
      if (profile == EdgeIndexProfile::Working)
      {
        last = sum;
      }
    }
  }
}

TEST(EdgeIndex, BothProfilesGiveTheSamePointsOnAnyNumberOfThreads)
{
  auto volume = MakeWaves<float>({ 70, 50, 40 }, 0.1);
  TestBlockSource<float> source(volume, 16);
  const ContourRequest request = MakeRequest({ 0.05, -0.2 });
  for (const EdgeIndexMode mode :
    { EdgeIndexMode::Lossless, EdgeIndexMode::Bounded, EdgeIndexMode::Quantized })
  {
    EdgeIndexHeader header = MakeHeader(volume, request.Isovalues, mode, EdgeIndexProfile::Small);
    header.Settings.QuantizationMinimum = -1;
    header.Settings.QuantizationMaximum = 1;
    const Surface expected = EncodeAndDecode(header, source, request);
    ASSERT_GT(expected.NumberOfTriangles, 10000u);
    header.Settings.Profile = EdgeIndexProfile::Working;
    const auto bytes = Require(EncodeSurface(header, source, 1));
    for (const int threads : { 1, 2, 3, 8 })
    {
      EXPECT_EQ(bytes, Require(EncodeSurface(header, source, threads)));
      const Surface decoded = Require(DecodeSurface(bytes.data(), bytes.size(), request, threads));
      ExpectSameTopology(expected, decoded);
      EXPECT_TRUE(HaveEqualBytes(expected.Points, decoded.Points)) << threads;
    }
  }
}

// A point is NaN exactly where it is one of the samples, whatever the isovalue is to the levels.
TEST(EdgeIndex, QuantizedNotANumberStaysSo)
{
  auto volume = MakeWaves<float>({ 40, 33, 30 }, 0.1);
  for (std::size_t n = 0; n < volume.Samples.size(); n += 37)
  {
    volume.Samples[n] = std::numeric_limits<float>::quiet_NaN();
  }
  TestBlockSource<float> source(volume, 16);
  const double isovalues[] = { 0.05, -0.9, -3, 3 };
  for (const double isovalue : isovalues)
  {
    const ContourRequest request = MakeRequest({ isovalue });
    const auto expected = ExtractSurface(volume.Geometry, source, request, 1);
    for (const EdgeIndexProfile profile : AllProfiles)
    {
      const EdgeIndexHeader header =
        MakeHeader(volume, { isovalue }, EdgeIndexMode::Quantized, profile);
      const Surface decoded = QuantizeSurface(header, 10, source, request, *expected);
      std::size_t count = 0;
      for (std::size_t n = 0; n < expected->Points.GetSize(); ++n)
      {
        EXPECT_EQ(std::isnan(expected->Points[n]), std::isnan(decoded.Points[n])) << n;
        count += std::isnan(expected->Points[n]) ? 1 : 0;
      }
      EXPECT_EQ(count > 100, isovalue < 1);
    }
  }
}

TEST(EdgeIndex, InvalidBlocksAreRefused)
{
  const auto volume = MakeWaves<float>({ 20, 20, 20 }, 0);
  TestBlockSource<float> source(volume, 16);
  EdgeIndexHeader header =
    MakeHeader(volume, { 0.0 }, EdgeIndexMode::Bounded, EdgeIndexProfile::Small);
  for (const double error : { 0.0, -1.0, 0.6, 1e-9, std::nan("") })
  {
    header.Settings.MaximumError = error;
    EXPECT_EQ(EncodeSurface(header, source, 1).GetStatus().GetCode(), StatusCode::InvalidArgument);
  }
  header.Settings = {};
  header.Type = ValueType::UInt8;
  EXPECT_EQ(EncodeSurface(header, source, 1).GetStatus().GetCode(), StatusCode::InvalidArgument);
  header.Type = ValueType::Float32;
  header.Geometry.Extent = { 0, 3, 0, 3, 0, 3 };
  EXPECT_EQ(EncodeSurface(header, source, 1).GetStatus().GetCode(), StatusCode::InvalidArgument);
  source.Failing = 1;
  header.Geometry = volume.Geometry;
  EXPECT_EQ(EncodeSurface(header, source, 2).GetStatus().GetCode(), StatusCode::IoError);
}

TEST(EdgeIndex, TheFirstBlockIsDecodedBeforeAHundredthIsEncoded)
{
  const auto volume = MakeWaves<std::uint8_t>({ 81, 81, 81 }, 0.3);
  TestBlockSource<std::uint8_t> source(volume, 8);
  const EdgeIndexHeader header =
    MakeHeader(volume, { 120.5 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
  EdgeIndexEncoder encoder(header);
  std::vector<std::uint8_t> bytes;
  std::size_t block = 0;
  while (bytes.empty())
  {
    const auto samples = Require(source.Acquire(block));
    ASSERT_TRUE(encoder.EncodeBlock(source.GetLatticeCoordinates(block), samples, 0, bytes).IsOk());
    ++block;
  }
  std::size_t used = 0;
  const auto record = Require(EdgeIndexRecord::Parse(header, bytes.data(), bytes.size(), used));
  EdgeIndexBlockSource decoded(header, { record });
  const auto first = Require(ExtractSurface(header.Geometry, decoded, MakeRequest({ 120.5 }), 1));
  const auto all = ExtractSurface(volume.Geometry, source, MakeRequest({ 120.5 }), 1);
  EXPECT_GT(first.NumberOfTriangles, 0u);
  EXPECT_LT(100 * first.NumberOfTriangles, all->NumberOfTriangles);
}
