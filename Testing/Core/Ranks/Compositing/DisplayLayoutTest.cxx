// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/DisplayLayout.h"

#include <gtest/gtest.h>

using namespace isosurface;

namespace
{

const std::vector<DisplayTile> Tiles = { { { 110, 0, 100, 50 }, 1 }, { { 0, 0, 100, 50 }, 0 },
  { { 0, 60, 100, 50 }, 2 } };

} // namespace

TEST(DisplayLayout, TheExtentContainsAllTilesAndTheLowLeftCorner)
{
  EXPECT_EQ(DisplayLayout{}.GetExtent(), PixelRectangle());
  EXPECT_EQ(MakeDisplayLayout(Tiles, 1).GetExtent(), (PixelRectangle{ 0, 0, 210, 110 }));
  EXPECT_EQ(MakeDisplayLayout({ Tiles[0] }, 1).GetExtent(), (PixelRectangle{ 0, 0, 210, 50 }));
}

TEST(DisplayLayout, WithTwoSamplesPerPixelTilesAreTwiceAsLarge)
{
  const DisplayLayout display = MakeDisplayLayout(Tiles, 2);
  EXPECT_EQ(display.GetExtent(), (PixelRectangle{ 0, 0, 420, 220 }));
  EXPECT_EQ(display.Tiles[0].Pixels, (PixelRectangle{ 220, 0, 200, 100 }));
  for (std::size_t tile = 0; tile < Tiles.size(); ++tile)
  {
    EXPECT_EQ(display.CoverWithPixels(display.Tiles[tile].Pixels), Tiles[tile].Pixels);
    EXPECT_EQ(display.Tiles[tile].Rank, Tiles[tile].Rank);
  }
  EXPECT_EQ(display.CoverWithPixels({ 3, 4, 2, 1 }), (PixelRectangle{ 1, 2, 2, 1 }));
}

TEST(DisplayLayout, FindsTheTileOfARank)
{
  const DisplayLayout display = MakeDisplayLayout(Tiles, 1);
  EXPECT_EQ(display.FindTile(2), &display.Tiles[2]);
  EXPECT_EQ(display.FindTile(3), nullptr);
}
