// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/ViewportOutlines.h"

#include <gtest/gtest.h>

#include <set>

using namespace isosurface;

namespace
{

constexpr PixelRectangle OutlinedDisplay{ 0, 0, 60, 40 };

std::vector<std::uint32_t> DrawOn(
  const PixelRectangle& tile, const std::vector<Viewport>& viewports)
{
  std::vector<std::uint32_t> colors(static_cast<std::size_t>(tile.GetArea()), 7);
  const DisplayTile shown{ tile, 0 };
  DrawViewportOutlines(
    viewports, MakeDisplayLayout({ { OutlinedDisplay, 0 } }, 1), shown, colors.data());
  return colors;
}

} // namespace

TEST(ViewportOutlines, AreTwoPixelsWideInsideTheViewport)
{
  const PixelRectangle pixels{ 10, 5, 20, 16 };
  const std::vector<std::uint32_t> colors =
    DrawOn(OutlinedDisplay, { {}, MakeViewport(pixels, 1) });
  for (int y = 0; y < OutlinedDisplay.Height; ++y)
  {
    for (int x = 0; x < OutlinedDisplay.Width; ++x)
    {
      const bool isLine = pixels.Contains(x, y) && !PixelRectangle{ 12, 7, 16, 12 }.Contains(x, y);
      EXPECT_EQ(colors[static_cast<std::size_t>(y * OutlinedDisplay.Width + x)],
        isLine ? GetOutlineColor(1) : 7U);
    }
  }
}

TEST(ViewportOutlines, OfATileAreThoseOfTheDisplay)
{
  const std::vector<Viewport> viewports = { MakeViewport({ 3, 4, 50, 30 }, 1),
    MakeViewport({ 20, 8, 39, 31 }, 2), MakeViewport({ 30, 30, 2, 2 }, 4) };
  const std::vector<std::uint32_t> all = DrawOn(OutlinedDisplay, viewports);
  const PixelRectangle tile{ 15, 10, 33, 26 };
  const std::vector<std::uint32_t> ofTile = DrawOn(tile, viewports);
  for (int y = tile.Y; y < tile.GetTop(); ++y)
  {
    for (int x = tile.X; x < tile.GetRight(); ++x)
    {
      EXPECT_EQ(ofTile[static_cast<std::size_t>((y - tile.Y) * tile.Width + x - tile.X)],
        all[static_cast<std::size_t>(y * OutlinedDisplay.Width + x)]);
    }
  }
}

TEST(ViewportOutlines, CoarseViewportsAreDashed)
{
  const std::vector<std::uint32_t> colors =
    DrawOn(OutlinedDisplay, { MakeViewport(OutlinedDisplay, 2) });
  int line = 0;
  for (int x = 0; x < OutlinedDisplay.Width; ++x)
  {
    line += colors[static_cast<std::size_t>(x)] == GetOutlineColor(0) ? 1 : 0;
  }
  EXPECT_GT(line, OutlinedDisplay.Width / 4);
  EXPECT_LT(line, OutlinedDisplay.Width * 3 / 4);
}

TEST(ViewportOutlines, WithAntialiasingAreThoseOfThePixels)
{
  const PixelRectangle pixels{ 10, 5, 20, 16 };
  const DisplayLayout display = MakeDisplayLayout({ { OutlinedDisplay, 0 } }, 2);
  std::vector<std::uint32_t> colors(static_cast<std::size_t>(OutlinedDisplay.GetArea()), 7);
  DrawViewportOutlines(
    { MakeViewport({ 20, 10, 40, 32 }, 1) }, display, display.Tiles[0], colors.data());
  EXPECT_EQ(colors, DrawOn(OutlinedDisplay, { MakeViewport(pixels, 1) }));
}

TEST(ViewportOutlines, ColorsOfRanksAreOpaqueAndDiffer)
{
  std::set<std::uint32_t> colors;
  for (int rank = 0; rank < 32; ++rank)
  {
    EXPECT_EQ(GetOutlineColor(rank) >> 24U, 255U);
    colors.insert(GetOutlineColor(rank));
  }
  EXPECT_EQ(colors.size(), 32U);
}
