// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/PixelRuns.h"

#include "RandomImages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

using namespace isosurface;

namespace
{

constexpr PixelRectangle Raster{ 13, 7, 53, 31 };

/// A rectangle of an image as it should arrive: inactive pixels have color 0 and depth 1.
ImageBuffer CutActive(const ImageBuffer& image, const PixelRectangle& part)
{
  ImageBuffer cut;
  cut.Raster = part;
  for (int y = part.Y; y < part.GetTop(); ++y)
  {
    for (int x = part.X; x < part.GetRight(); ++x)
    {
      const std::size_t index = image.GetView().GetIndex(x, y);
      const bool isActive = image.Depths[index] < 1.0F;
      cut.Colors.push_back(isActive ? image.Colors[index] : 0);
      cut.Depths.push_back(isActive ? image.Depths[index] : 1.0F);
    }
  }
  return cut;
}

ImageBuffer Paint(const ActivePixels& pixels, const PixelRectangle& part)
{
  ImageBuffer image;
  image.Raster = part;
  image.Colors.assign(static_cast<std::size_t>(part.GetArea()), 0);
  image.Depths.assign(static_cast<std::size_t>(part.GetArea()), 1.0F);
  for (const PixelRun& run : pixels.Runs)
  {
    const std::size_t index = image.GetView().GetIndex(run.X, run.Y);
    std::copy_n(pixels.Colors.begin() + static_cast<std::ptrdiff_t>(run.First), run.Length,
      image.Colors.begin() + static_cast<std::ptrdiff_t>(index));
    if (!pixels.Depths.empty())
    {
      std::copy_n(pixels.Depths.begin() + static_cast<std::ptrdiff_t>(run.First), run.Length,
        image.Depths.begin() + static_cast<std::ptrdiff_t>(index));
    }
  }
  return image;
}

void ExpectRoundTrip(const ImageBuffer& image, const PixelRectangle& part)
{
  const ImageBuffer expected = CutActive(image, part);
  Message bytes(3, 99);
  AppendActivePixels(image.GetView(), part, PixelContent::ColorsAndDepths, bytes);
  const std::size_t second = bytes.size();
  AppendActivePixels(image.GetView(), part, PixelContent::Colors, bytes);

  std::size_t offset = 3;
  ActivePixels pixels;
  ASSERT_TRUE(ReadActivePixels(bytes, part, PixelContent::ColorsAndDepths, offset, pixels).IsOk());
  EXPECT_EQ(offset, second);
  const ImageBuffer full = Paint(pixels, part);
  EXPECT_EQ(full.Colors, expected.Colors);
  // Bit for bit: a depth of -0 is not one of 0.
  EXPECT_TRUE(std::equal(full.Depths.begin(), full.Depths.end(), expected.Depths.begin(),
    expected.Depths.end(), [](float a, float b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }));
  ASSERT_TRUE(ReadActivePixels(bytes, part, PixelContent::Colors, offset, pixels).IsOk());
  EXPECT_EQ(offset, bytes.size());
  EXPECT_EQ(Paint(pixels, part).Colors, expected.Colors);
  EXPECT_TRUE(pixels.Depths.empty());
}

Message MakeBytes(const ImageBuffer& image, PixelContent content)
{
  Message bytes;
  AppendActivePixels(image.GetView(), image.Raster, content, bytes);
  return bytes;
}

} // namespace

TEST(FindActive, IsTheFirstOfARowWhereverItBeginsAndEnds)
{
  std::vector<float> depths(150, 1.0F);
  depths[3] = std::numeric_limits<float>::quiet_NaN(); // not active either
  for (const int active : { 0, 31, 32, 63, 100, 149 })
  {
    depths[static_cast<std::size_t>(active)] = 0.5F;
    for (int begin = 0; begin < 150; ++begin)
    {
      for (const int end : { begin, 40, 64, 149, 150 })
      {
        const int expected = begin <= active && active < end ? active : std::max(begin, end);
        EXPECT_EQ(FindActive(depths.data(), begin, std::max(begin, end)), expected);
      }
    }
    EXPECT_EQ(FindInactive(depths.data(), active, 150), active + 1);
    depths[static_cast<std::size_t>(active)] = 1.0F;
  }
}

TEST(PixelRuns, AnyRectangleOfAnyImageArrivesBitForBit)
{
  std::mt19937 random(1);
  for (unsigned trial = 0; trial < 100; ++trial)
  {
    const ImageBuffer image = MakeRandomImage(Raster, trial);
    ExpectRoundTrip(image, MakeRandomRectangle(Raster, random));
  }
}

TEST(PixelRuns, FullEmptyAndSinglePixels)
{
  ImageBuffer image = MakeRandomImage(Raster, 1);
  std::fill(image.Depths.begin(), image.Depths.end(), 0.25F);
  ExpectRoundTrip(image, Raster);
  std::fill(image.Depths.begin(), image.Depths.end(), 1.0F);
  ExpectRoundTrip(image, Raster);
  ExpectRoundTrip(image, { 20, 10, 0, 5 });
  image.Depths.back() = 0.0F;
  ExpectRoundTrip(image, Raster);
}

TEST(PixelRuns, DepthsOfAllRangesArriveBitForBit)
{
  ImageBuffer image = MakeRandomImage(Raster, 2);
  std::mt19937 random(9);
  for (const float low : { -1.0F, 0.0F, 1e-30F, 0.3F, 0.6F, 0.999F })
  {
    for (float& depth : image.Depths)
    {
      depth = low + (1.0001F - low) * static_cast<float>(random() % 100000) / 100000.0F;
    }
    ExpectRoundTrip(image, Raster);
  }
  // NaN is not less than 1: nothing was drawn there.
  image.Depths[17] = std::numeric_limits<float>::quiet_NaN();
  ExpectRoundTrip(image, Raster);
}

TEST(PixelRuns, OpaquePixelsTakeThreeBytesAndDepthsOfAScreenThree)
{
  ImageBuffer image = MakeRandomImage(Raster, 3);
  std::fill(image.Depths.begin(), image.Depths.end(), 0.75F);
  image.Depths[0] = 0.3F;
  const auto count = static_cast<std::size_t>(Raster.GetArea());
  EXPECT_LT(MakeBytes(image, PixelContent::ColorsAndDepths).size(), 7 * count + 20);
  for (std::uint32_t& color : image.Colors)
  {
    color |= 0xff000000U;
  }
  ExpectRoundTrip(image, Raster);
  EXPECT_LT(MakeBytes(image, PixelContent::ColorsAndDepths).size(), 6 * count + 20);
  EXPECT_LT(MakeBytes(image, PixelContent::Colors).size(), 3 * count + 20);
}

TEST(PixelRuns, TruncatedBytesAreCorrupt)
{
  const Message bytes = MakeBytes(MakeRandomImage(Raster, 4), PixelContent::ColorsAndDepths);
  ActivePixels pixels;
  for (std::size_t size = 0; size < bytes.size(); size += size < 40 ? 1 : 37)
  {
    const Message cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    std::size_t offset = 0;
    EXPECT_EQ(
      ReadActivePixels(cut, Raster, PixelContent::ColorsAndDepths, offset, pixels).GetCode(),
      StatusCode::Corrupt)
      << size;
    EXPECT_EQ(offset, 0U);
  }
  std::size_t beyond = bytes.size() + 5;
  EXPECT_FALSE(
    ReadActivePixels(bytes, Raster, PixelContent::ColorsAndDepths, beyond, pixels).IsOk());
}

TEST(PixelRuns, OtherBytesAreCorruptOrPixelsInsideTheRectangle)
{
  std::mt19937 random(8);
  const Message good = MakeBytes(MakeRandomImage(Raster, 5), PixelContent::ColorsAndDepths);
  int corrupt = 0;
  for (int trial = 0; trial < 3000; ++trial)
  {
    Message bytes = good;
    for (unsigned change = 0; change <= random() % 3; ++change)
    {
      // Mostly in the header and the runs, where it matters.
      bytes[random() % (trial % 2 == 0 ? 20 : 400)] = static_cast<std::uint8_t>(random());
    }
    ActivePixels pixels;
    std::size_t offset = 0;
    if (!ReadActivePixels(bytes, Raster, PixelContent::ColorsAndDepths, offset, pixels).IsOk())
    {
      ++corrupt;
      continue;
    }
    EXPECT_LE(offset, bytes.size());
    std::size_t count = 0;
    for (const PixelRun& run : pixels.Runs)
    {
      const PixelRectangle place{ run.X, run.Y, run.Length, 1 };
      EXPECT_EQ(place.Intersect(Raster), place);
      EXPECT_EQ(run.First, count);
      count += static_cast<std::size_t>(run.Length);
    }
    EXPECT_EQ(pixels.Colors.size(), count);
    EXPECT_EQ(pixels.Depths.size(), count);
  }
  EXPECT_GT(corrupt, 1000);
}

TEST(PixelRuns, BytesOfAnotherContentOrALargerImageAreCorrupt)
{
  const Message bytes = MakeBytes(MakeRandomImage(Raster, 6), PixelContent::ColorsAndDepths);
  ActivePixels pixels;
  std::size_t offset = 0;
  EXPECT_FALSE(ReadActivePixels(bytes, Raster, PixelContent::Colors, offset, pixels).IsOk());
  EXPECT_FALSE(
    ReadActivePixels(bytes, { 13, 7, 20, 20 }, PixelContent::ColorsAndDepths, offset, pixels)
      .IsOk());
}
