// SPDX-License-Identifier: BSD-3-Clause
// Images that are upsampled smoothly or averaged, beside sums in floating point.
#include "Ranks/Compositing/ImageScaling.h"

#include "Ranks/Compositing/DisplayLayout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace isosurface;

namespace
{

ImageBuffer MakeImage(const PixelRectangle& raster, std::mt19937& random)
{
  ImageBuffer image;
  image.Resize(raster);
  std::uniform_real_distribution<float> depth(0.2F, 1.4F);
  for (std::size_t pixel = 0; pixel < image.Colors.size(); ++pixel)
  {
    image.Depths[pixel] = std::min(1.0F, depth(random));
    image.Colors[pixel] = image.Depths[pixel] < 1.0F ? static_cast<std::uint32_t>(random()) : 0;
  }
  return image;
}

unsigned GetByte(std::uint32_t color, int byte)
{
  return color >> (8 * byte) & 0xffU;
}

} // namespace

TEST(ImageScaling, UpsampledColorsAreBilinearAmongActiveSamples)
{
  std::mt19937 random(5);
  for (const int divisor : { 1, 2, 3, 4, 7, 64 })
  {
    const PixelRectangle raster{ 3, 2, 6, 5 };
    const ImageBuffer image = MakeImage(raster, random);
    // Blocks at the display's edge may reach beyond it.
    const PixelRectangle pixels = PixelRectangle::FromEdges(
      3 * divisor, 2 * divisor, 9 * divisor - divisor / 2, 7 * divisor - divisor / 3);
    ImageBuffer upsampled;
    UpsampleSmoothly(image.GetView(), divisor, pixels, upsampled);
    ASSERT_EQ(upsampled.Raster, pixels);
    for (int y = pixels.Y; y < pixels.GetTop(); ++y)
    {
      for (int x = pixels.X; x < pixels.GetRight(); ++x)
      {
        const std::size_t pixel = upsampled.GetView().GetIndex(x, y);
        const std::size_t own = image.GetView().GetIndex(x / divisor, y / divisor);
        EXPECT_EQ(upsampled.Depths[pixel], image.Depths[own]);
        if (!(image.Depths[own] < 1.0F))
        {
          EXPECT_EQ(upsampled.Colors[pixel], 0U);
          continue;
        }
        // Every sample in the image has the weight of a tent one block wide to each side.
        for (int byte = 0; byte < 4; ++byte)
        {
          double sum = 0;
          double weights = 0;
          for (int row = raster.Y; row < raster.GetTop(); ++row)
          {
            for (int column = raster.X; column < raster.GetRight(); ++column)
            {
              const std::size_t sample = image.GetView().GetIndex(column, row);
              const double across = std::abs((x + 0.5) / divisor - (column + 0.5));
              const double up = std::abs((y + 0.5) / divisor - (row + 0.5));
              if (across < 1 && up < 1 && image.Depths[sample] < 1.0F)
              {
                const double weight = (1 - across) * (1 - up);
                sum += weight * GetByte(image.Colors[sample], byte);
                weights += weight;
              }
            }
          }
          EXPECT_NEAR(GetByte(upsampled.Colors[pixel], byte), sum / weights, 0.5 + 1e-9);
        }
      }
    }
  }
}

TEST(ImageScaling, UpsampledBlocksHaveOneSampleAndLeaveOtherPixels)
{
  std::mt19937 random(8);
  const PixelRectangle display{ 0, 0, 31, 23 };
  for (const int divisor : { 1, 2, 3, 5 })
  {
    const PixelRectangle pixels{ 7, 4, 20, 17 };
    const ImageBuffer image = MakeImage(CoverWithBlocks(pixels, divisor), random);
    ImageBuffer upsampled;
    upsampled.Clear(display);
    UpsampleBlocks(image.GetView(), divisor, pixels, upsampled);
    for (int y = 0; y < display.Height; ++y)
    {
      for (int x = 0; x < display.Width; ++x)
      {
        const auto pixel = static_cast<std::size_t>(y * display.Width + x);
        const bool isInside = pixels.Contains(x, y);
        const std::size_t own =
          isInside ? image.GetView().GetIndex(x / divisor, y / divisor) : std::size_t{ 0 };
        EXPECT_EQ(upsampled.Colors[pixel], isInside ? image.Colors[own] : 0U);
        EXPECT_EQ(upsampled.Depths[pixel], isInside ? image.Depths[own] : 1.0F);
      }
    }
  }
}

TEST(ImageScaling, UpsamplingByOneChangesNothing)
{
  std::mt19937 random(6);
  const ImageBuffer image = MakeImage({ 10, 20, 17, 9 }, random);
  ImageBuffer upsampled;
  UpsampleSmoothly(image.GetView(), 1, image.Raster, upsampled);
  EXPECT_EQ(upsampled.Colors, image.Colors);
  EXPECT_EQ(upsampled.Depths, image.Depths);
}

TEST(ImageScaling, AveragesAreThoseOfFourSamples)
{
  std::mt19937 random(7);
  constexpr int Width = 13;
  constexpr int Height = 7;
  const ImageBuffer fine = MakeImage({ 0, 0, 2 * Width, 2 * Height }, random);
  std::vector<std::uint32_t> colors(Width * Height);
  std::vector<float> depths(Width * Height);
  AverageSamples(
    fine.Colors.data(), fine.Depths.data(), Width, Height, colors.data(), depths.data());
  for (int y = 0; y < Height; ++y)
  {
    for (int x = 0; x < Width; ++x)
    {
      float nearest = 1.0F;
      std::vector<unsigned> sums(4, 0);
      for (int sample = 0; sample < 4; ++sample)
      {
        const std::size_t index = fine.GetView().GetIndex(2 * x + sample % 2, 2 * y + sample / 2);
        nearest = std::min(nearest, fine.Depths[index]);
        for (int byte = 0; byte < 4; ++byte)
        {
          sums[static_cast<std::size_t>(byte)] += GetByte(fine.Colors[index], byte);
        }
      }
      const auto pixel = static_cast<std::size_t>(y * Width + x);
      EXPECT_EQ(depths[pixel], nearest);
      for (int byte = 0; byte < 4; ++byte)
      {
        EXPECT_EQ(GetByte(colors[pixel], byte),
          std::floor(sums[static_cast<std::size_t>(byte)] / 4.0 + 0.5));
      }
    }
  }
}

TEST(ImageScaling, AveragesWithoutDepths)
{
  const std::vector<std::uint32_t> fine = { 0xffffffffU, 0xffffffffU, 0xffffffffU, 0 };
  std::uint32_t color = 0;
  AverageSamples(fine.data(), nullptr, 1, 1, &color, nullptr);
  EXPECT_EQ(color, 0xbfbfbfbfU); // 765 / 4 = 191.25
}
