// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/LongTests.h"
#include "Fixtures/PlainContour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace isosurface;

namespace
{

// Checks what does not need the oracle: sizes, ranges, parts.
void CheckShape(const Surface& surface, const ContourRequest& request)
{
  EXPECT_EQ(surface.Points.GetSize(), 3 * surface.NumberOfPoints);
  EXPECT_EQ(surface.Connectivity.GetSize(), 3 * surface.NumberOfTriangles);
  EXPECT_EQ(surface.Parts.size(), request.Isovalues.size());
  ExpectWholeParts(surface);
}

template <typename T>
void CheckWholeSurface(const SampleVolume<T>& volume, int blockSize,
  const std::vector<double>& isovalues, int threads = 1, int components = 1)
{
  const ContourRequest request = MakePlainRequest(isovalues);
  const Surface surface = ExtractBlocks(volume, blockSize, request, threads, components);
  CheckShape(surface, request);
  const PlainSurface plain = MakePlain(surface);
  EXPECT_EQ(plain.Points.size(), surface.NumberOfPoints) << "a point is there twice";
  EXPECT_TRUE(plain == ContourPlainly(volume, isovalues));
}

template <typename T>
class SurfaceOfType : public testing::Test
{
};
TYPED_TEST_SUITE(SurfaceOfType, AllValueTypes);

} // namespace

TYPED_TEST(SurfaceOfType, EveryCellCaseEqualsOracle)
{
  for (unsigned cellCase = 0; cellCase < 256; ++cellCase)
  {
    SampleVolume<TypeParam> volume({ 2, 2, 2 });
    for (unsigned vertex = 0; vertex < 8; ++vertex)
    {
      volume.Samples[vertex] = static_cast<TypeParam>(cellCase >> vertex & 1 ? 7 + vertex : 1);
    }
    CheckWholeSurface(volume, 16, { 6.5 });
  }
}

TYPED_TEST(SurfaceOfType, RandomSmallGridsInSmallBlocksEqualOracle)
{
  std::mt19937 random(20);
  std::uniform_int_distribution<int> size(1, 9);
  std::uniform_int_distribution<int> blockSize(1, 5);
  for (int trial = 0; trial < ChooseTrials(300); ++trial)
  {
    const Index3 dimensions{ size(random), size(random), size(random) };
    const auto volume = MakeRandomVolume<TypeParam>(random, dimensions, trial % 2 == 0 ? 4 : 100);
    // Integers equal samples, halves lie between them.
    CheckWholeSurface(volume, blockSize(random), { trial % 3 == 0 ? 1.0 : 1.5 }, 1, trial % 4 + 1);
  }
}

TYPED_TEST(SurfaceOfType, BlocksOfAllSizesEqualOracle)
{
  std::mt19937 random(21);
  const Index3 sizes[] = { { 70, 5, 4 }, { 4, 67, 3 }, { 3, 4, 66 }, { 34, 33, 2 }, { 65, 3, 33 } };
  for (const Index3& dimensions : sizes)
  {
    const auto volume = MakeRandomVolume<TypeParam>(random, dimensions, 100);
    for (const int blockSize : { 16, 32, 64 })
    {
      CheckWholeSurface(volume, blockSize, { 30.25 }, 2);
    }
  }
}

TEST(SurfaceExtractor, ExtremesOfWideIntegersDoNotOverflow)
{
  using Signed = std::numeric_limits<std::int64_t>;
  using Unsigned = std::numeric_limits<std::uint64_t>;
  std::mt19937 random(22);
  SampleVolume<std::int64_t> wide({ 4, 4, 4 });
  SampleVolume<std::uint64_t> wideUnsigned({ 4, 4, 4 });
  SampleVolume<std::int32_t> narrow({ 4, 4, 4 });
  for (std::size_t n = 0; n < 64; ++n)
  {
    const bool inside = random() % 2 == 0;
    wide.Samples[n] = inside ? Signed::max() : Signed::min();
    wideUnsigned.Samples[n] = inside ? Unsigned::max() - n : n;
    narrow.Samples[n] = inside ? std::numeric_limits<std::int32_t>::max() - static_cast<int>(n)
                               : std::numeric_limits<std::int32_t>::min() + static_cast<int>(n);
  }
  CheckWholeSurface(wide, 2, { 0.0 });
  CheckWholeSurface(wideUnsigned, 2, { 9007199254740993.0 });
  CheckWholeSurface(narrow, 2, { -12345.5 });
}

TEST(SurfaceExtractor, WideIntegersThatRoundToTheSameDoubleAreDistinguished)
{
  // Only one of the samples is inside.
  SampleVolume<std::int64_t> volume({ 2, 2, 2 });
  const std::int64_t limit = std::int64_t(1) << 60;
  std::fill(volume.Samples.begin(), volume.Samples.end(), limit - 1);
  volume.Samples[3] = limit;
  const Surface surface =
    ExtractBlocks(volume, 16, MakePlainRequest({ static_cast<double>(limit) }));
  EXPECT_EQ(surface.NumberOfTriangles, 1u);
  for (const float coordinate : surface.Points)
  {
    EXPECT_GE(coordinate, 0.0f);
    EXPECT_LE(coordinate, 1.0f);
  }
}

TEST(SurfaceExtractor, InfinitiesAndNaNEqualOracle)
{
  std::mt19937 random(23);
  for (int trial = 0; trial < ChooseTrials(100); ++trial)
  {
    auto volume = MakeRandomVolume<float>(random, { 5, 6, 4 }, 10);
    for (float& sample : volume.Samples)
    {
      const auto draw = random() % 12;
      sample = draw == 0 ? std::numeric_limits<float>::infinity()
        : draw == 1      ? -std::numeric_limits<float>::infinity()
        : draw == 2      ? std::numeric_limits<float>::max()
        : draw == 3      ? std::numeric_limits<float>::denorm_min()
        : draw == 4      ? -0.0f
                         : sample;
    }
    CheckWholeSurface(volume, 3, { trial % 2 == 0 ? 0.0 : 1.25 });
  }
}

TEST(SurfaceExtractor, SeveralIsovaluesAreSeparatePartsOfOneSurface)
{
  std::mt19937 random(24);
  const auto volume = MakeRandomVolume<std::int16_t>(random, { 21, 18, 17 }, 200);
  CheckWholeSurface(volume, 16, { 10.5, -40.0, 10.5, 99.0 }, 2);
}

TEST(SurfaceExtractor, IsovaluesWithoutSurfaceGiveEmptyParts)
{
  std::mt19937 random(25);
  const auto volume = MakeRandomVolume<std::uint8_t>(random, { 6, 6, 6 }, 200);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ContourRequest request = MakePlainRequest({ nan, 255.5, 1e300, -1.0, 0.0, 100.0 });
  const Surface surface = ExtractBlocks(volume, 16, request);
  CheckShape(surface, request);
  for (std::size_t n = 0; n < 5; ++n)
  {
    EXPECT_EQ(surface.Parts[n].NumberOfPoints, 0u);
  }
  EXPECT_GT(surface.Parts[5].NumberOfCells, 0u);
}

TEST(SurfaceExtractor, FlatAndEmptyGridsHaveNoSurface)
{
  std::mt19937 random(26);
  for (const Index3& dimensions : { Index3{ 1, 1, 1 }, Index3{ 1, 9, 9 }, Index3{ 9, 1, 9 },
         Index3{ 9, 9, 1 }, Index3{ 0, 0, 0 } })
  {
    const auto volume = MakeRandomVolume<float>(random, dimensions, 4);
    const Surface surface = ExtractBlocks(volume, 16, MakePlainRequest({ 1.5 }));
    EXPECT_EQ(surface.NumberOfPoints, 0u);
    EXPECT_EQ(surface.NumberOfCells, 0u);
  }
}

TEST(SurfaceExtractor, NegativeExtentsAndOriginEqualOracle)
{
  std::mt19937 random(27);
  auto volume = MakeRandomVolume<std::uint16_t>(random, { 19, 8, 12 }, 60000);
  volume.Geometry.Extent = { -1000, -982, 7, 14, -12, -1 };
  CheckWholeSurface(volume, 16, { 30000.0 });
  volume.Geometry.Origin = { 0.1, -7.3, 1e6 };
  CheckWholeSurface(volume, 16, { 30000.0 });
}

TEST(SurfaceExtractor, ObliqueGridsTransformPointsAndNormals)
{
  std::mt19937 random(28);
  auto volume = MakeRandomVolume<std::uint16_t>(random, { 19, 8, 12 }, 60000);
  const PlainSurface straight = MakePlain(ExtractBlocks(volume, 16, MakePlainRequest({ 30000.0 })));
  const double cosine = std::cos(0.7);
  const double sine = std::sin(0.7);
  for (const double flip : { 1.0, -1.0 })
  {
    volume.Geometry.Direction = { cosine, -sine, 0, sine, cosine, 0, 0, 0, flip };
    volume.Geometry.Spacing = { 0.3, 1.7, 2.1 };
    volume.Geometry.Origin = { 1, 2, 3.3 };
    const PlainSurface surface =
      MakePlain(ExtractBlocks(volume, 16, MakePlainRequest({ 30000.0 })));
    const PlainSurface oracle = ContourPlainly(volume, { 30000.0 });
    ASSERT_EQ(surface.Triangles, oracle.Triangles);
    ASSERT_EQ(surface.Points.size(), oracle.Points.size());
    for (const auto& [id, bits] : surface.Points)
    {
      const PointBits& plain = straight.Points.at(id);
      double dot = 0;
      double norm = 0;
      double turned[3];
      float before[3];
      float after[3];
      std::memcpy(before, &plain[3], sizeof(before));
      std::memcpy(after, &bits[3], sizeof(after));
      for (std::size_t row = 0; row < 3; ++row)
      {
        EXPECT_EQ(bits[row], oracle.Points.at(id)[row]);
        turned[row] = 0;
        for (std::size_t column = 0; column < 3; ++column)
        {
          // The transposed inverse of a rotation, or of a reflection, is that itself.
          turned[row] += volume.Geometry.Direction[3 * row + column] *
            static_cast<double>(before[column]) / volume.Geometry.Spacing[column];
        }
        dot += turned[row] * static_cast<double>(after[row]);
        norm += turned[row] * turned[row];
      }
      if (norm > 0)
      {
        EXPECT_NEAR(dot / std::sqrt(norm), 1.0, 1e-5);
      }
    }
  }
}

TEST(SurfaceExtractor, TheResultDoesNotDependOnThreads)
{
  std::mt19937 random(29);
  const auto volume = MakeRandomVolume<std::uint16_t>(random, { 70, 40, 50 }, 1000);
  const ContourRequest request = MakePlainRequest({ 900.0, 990.0 });
  const Surface one = ExtractBlocks(volume, 16, request, 1);
  for (const int threads : { 2, 7 })
  {
    ExpectSameSurface(ExtractBlocks(volume, 16, request, threads), one);
  }
}

TEST(SurfaceExtractor, IndicesAreWideWhereEitherPointsOrCornersAreBeyond31Bits)
{
  constexpr std::size_t maximum = 2147483647;
  EXPECT_FALSE(NeedsWideIndices(maximum, maximum));
  EXPECT_TRUE(NeedsWideIndices(maximum + 1, 3));
  EXPECT_TRUE(NeedsWideIndices(3, maximum + 1)) << "offsets count corners, as connectivity does";
}

TEST(SurfaceExtractor, WideIndicesEqualNarrowOnes)
{
  std::mt19937 random(30);
  const auto volume = MakeRandomVolume<std::uint8_t>(random, { 30, 20, 25 }, 100);
  for (const bool polygons : { false, true })
  {
    ContourRequest request = MakePlainRequest({ 50.5 });
    request.Offsets = true;
    request.Polygons = polygons;
    const Surface narrow = ExtractBlocks(volume, 16, request);
    request.WideIndices = true;
    const Surface wide = ExtractBlocks(volume, 16, request);
    EXPECT_FALSE(narrow.Connectivity.Is64Bit);
    EXPECT_TRUE(wide.Connectivity.Is64Bit);
    ASSERT_EQ(narrow.Connectivity.GetSize(), wide.Connectivity.GetSize());
    for (std::size_t n = 0; n < wide.Connectivity.GetSize(); ++n)
    {
      ASSERT_EQ(narrow.Connectivity[n], wide.Connectivity[n]);
    }
    ASSERT_EQ(narrow.Offsets.GetSize(), narrow.NumberOfCells + 1);
    ASSERT_EQ(wide.Offsets.GetSize(), wide.NumberOfCells + 1);
    for (std::size_t n = 0; n <= wide.NumberOfCells; ++n)
    {
      ASSERT_EQ(narrow.Offsets[n], wide.Offsets[n]);
      if (!polygons)
      {
        ASSERT_EQ(wide.Offsets[n], 3 * static_cast<std::int64_t>(n));
      }
    }
  }
}
