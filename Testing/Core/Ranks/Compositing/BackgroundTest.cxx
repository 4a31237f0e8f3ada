// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/Background.h"

#include <gtest/gtest.h>

#include <cstddef>

using namespace isosurface;

namespace
{

constexpr int Width = 7;
constexpr int Height = 5;
constexpr PixelRectangle Rectangle{ 2, 1, 4, 3 };
constexpr std::uint32_t Background = 0xff102030U;

/// Opaque and empty pixels by turns.
std::vector<std::uint32_t> MakeColors()
{
  std::vector<std::uint32_t> colors;
  for (std::uint32_t pixel = 0; pixel < Width * Height; ++pixel)
  {
    colors.push_back(pixel % 3 == 0 ? 0 : 0xff000000U | pixel);
  }
  return colors;
}

} // namespace

TEST(Background, IsWhereNothingWasDrawn)
{
  const std::vector<std::uint32_t> colors = MakeColors();
  std::vector<std::uint32_t> result;
  EXPECT_TRUE(PutOverBackground(colors.data(), Width, Rectangle, Background, result));
  std::vector<std::uint32_t> expected;
  for (int y = Rectangle.Y; y < Rectangle.GetTop(); ++y)
  {
    for (int x = Rectangle.X; x < Rectangle.GetRight(); ++x)
    {
      const std::uint32_t color = colors[static_cast<std::size_t>(y * Width + x)];
      expected.push_back(color == 0 ? Background : color);
    }
  }
  EXPECT_EQ(result, expected);
}

TEST(Background, TranslucentPixelsOfTheRectangleAreRefused)
{
  std::vector<std::uint32_t> colors = MakeColors();
  std::vector<std::uint32_t> result;
  colors[0] = 0x80000000U; // outside
  EXPECT_TRUE(PutOverBackground(colors.data(), Width, Rectangle, Background, result));
  for (const std::uint32_t color : { 0x80000000U, 0xfe123456U, 0x00000001U })
  {
    colors[2 * Width + 3] = color;
    EXPECT_FALSE(PutOverBackground(colors.data(), Width, Rectangle, Background, result));
  }
}

TEST(Background, AnEmptyRectangleHasNoColors)
{
  std::vector<std::uint32_t> result(3);
  EXPECT_TRUE(PutOverBackground(nullptr, Width, {}, Background, result));
  EXPECT_TRUE(result.empty());
}
