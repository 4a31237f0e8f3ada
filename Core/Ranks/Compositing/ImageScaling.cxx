// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/ImageScaling.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace isosurface
{
namespace
{

constexpr unsigned BitsOfByte = 8;
constexpr std::size_t BytesOfColor = 4;

/// The weighted mean of colors, byte by byte.
class WeightedColor
{
public:
  void Add(std::uint32_t color, std::uint32_t weight)
  {
    for (std::size_t byte = 0; byte < BytesOfColor; ++byte)
    {
      this->Sums[byte] += weight * ((color >> (BitsOfByte * byte)) & 0xffU);
    }
    this->Weight += weight;
  }
  std::uint32_t GetMean() const
  {
    std::uint32_t color = 0;
    for (std::size_t byte = 0; byte < BytesOfColor; ++byte)
    {
      color |= (this->Sums[byte] + this->Weight / 2) / this->Weight << (BitsOfByte * byte);
    }
    return color;
  }

private:
  std::array<std::uint32_t, BytesOfColor> Sums{};
  std::uint32_t Weight = 0;
};

/// The two blocks between whose centers a pixel lies, and their weights, which add up to 2 * divisor.
struct BlockPair
{
  std::array<int, 2> Blocks;
  std::array<std::uint32_t, 2> Weights;

  BlockPair(int pixel, int divisor)
  {
    const int block = pixel / divisor;
    const int distance = 2 * (pixel - block * divisor) + 1 - divisor; // in half pixels
    this->Blocks = { block, distance < 0 ? block - 1 : block + 1 };
    const auto away = static_cast<std::uint32_t>(distance < 0 ? -distance : distance);
    this->Weights = { 2 * static_cast<std::uint32_t>(divisor) - away, away };
  }
};

std::uint32_t Interpolate(const ImageView& image, const BlockPair& columns, const BlockPair& rows)
{
  WeightedColor mean;
  for (std::size_t row = 0; row < 2; ++row)
  {
    for (std::size_t column = 0; column < 2; ++column)
    {
      const std::uint32_t weight = columns.Weights[column] * rows.Weights[row];
      if (weight == 0 || !image.Raster.Contains(columns.Blocks[column], rows.Blocks[row]))
      {
        continue;
      }
      const std::size_t sample = image.GetIndex(columns.Blocks[column], rows.Blocks[row]);
      if (image.Depths[sample] < 1.0F)
      {
        mean.Add(image.Colors[sample], weight);
      }
    }
  }
  return mean.GetMean();
}

} // namespace

void UpsampleBlocks(
  const ImageView& image, int divisor, const PixelRectangle& pixels, ImageBuffer& upsampled)
{
  for (int y = pixels.Y; y < pixels.GetTop(); ++y)
  {
    std::size_t pixel = upsampled.GetView().GetIndex(pixels.X, y);
    for (int x = pixels.X; x < pixels.GetRight(); ++x, ++pixel)
    {
      const std::size_t sample = image.GetIndex(x / divisor, y / divisor);
      upsampled.Colors[pixel] = image.Colors[sample];
      upsampled.Depths[pixel] = image.Depths[sample];
    }
  }
}

void UpsampleSmoothly(
  const ImageView& image, int divisor, const PixelRectangle& pixels, ImageBuffer& upsampled)
{
  upsampled.Resize(pixels);
  std::size_t pixel = 0;
  for (int y = pixels.Y; y < pixels.GetTop(); ++y)
  {
    const BlockPair rows(y, divisor);
    for (int x = pixels.X; x < pixels.GetRight(); ++x, ++pixel)
    {
      const BlockPair columns(x, divisor);
      const float depth = image.Depths[image.GetIndex(columns.Blocks[0], rows.Blocks[0])];
      upsampled.Depths[pixel] = depth;
      upsampled.Colors[pixel] = depth < 1.0F ? Interpolate(image, columns, rows) : 0;
    }
  }
}

void AverageSamples(const std::uint32_t* fineColors, const float* fineDepths, int width, int height,
  std::uint32_t* coarseColors, float* coarseDepths)
{
  // Even and odd bytes of a color are summed separately: a sum of four bytes fits in two bytes.
  constexpr std::uint32_t EvenBytes = 0x00ff00ffU;
  constexpr std::uint32_t Halves = 0x00020002U;
  const auto columns = static_cast<std::size_t>(width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
  {
    for (std::size_t x = 0; x < columns; ++x)
    {
      const std::size_t low = 2 * y * 2 * columns + 2 * x;
      const std::array<std::size_t, 4> samples = { low, low + 1, low + 2 * columns,
        low + 2 * columns + 1 };
      std::uint32_t even = Halves;
      std::uint32_t odd = Halves;
      for (const std::size_t sample : samples)
      {
        even += fineColors[sample] & EvenBytes;
        odd += fineColors[sample] >> BitsOfByte & EvenBytes;
      }
      coarseColors[y * columns + x] =
        (even >> 2U & EvenBytes) | (odd >> 2U & EvenBytes) << BitsOfByte;
      if (coarseDepths)
      {
        coarseDepths[y * columns + x] =
          std::min(std::min(fineDepths[samples[0]], fineDepths[samples[1]]),
            std::min(fineDepths[samples[2]], fineDepths[samples[3]]));
      }
    }
  }
}

} // namespace isosurface
