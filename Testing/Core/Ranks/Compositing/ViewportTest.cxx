// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/DisplayLayout.h"

#include <gtest/gtest.h>

using namespace isosurface;

TEST(Viewport, BlocksAreThoseWithAPixelInTheRectangle)
{
  const PixelRectangle display{ 0, 0, 37, 29 };
  for (const int divisor : { 1, 2, 3, 4, 8, 64 })
  {
    for (const PixelRectangle& pixels : { PixelRectangle{ 0, 0, 37, 29 },
           PixelRectangle{ 5, 7, 1, 1 }, PixelRectangle{ 36, 28, 1, 1 },
           PixelRectangle{ 8, 4, 16, 4 }, PixelRectangle{ 11, 3, 13, 25 } })
    {
      const PixelRectangle blocks = CoverWithBlocks(pixels, divisor);
      for (int y = 0; y < 64 / divisor; ++y)
      {
        for (int x = 0; x < 64 / divisor; ++x)
        {
          const PixelRectangle block{ x * divisor, y * divisor, divisor, divisor };
          EXPECT_EQ(blocks.Contains(x, y), !block.Intersect(pixels).IsEmpty())
            << divisor << ": " << x << ", " << y;
        }
      }
      // What the viewport covers is inside the display, though its last blocks may reach beyond it.
      const PixelRectangle covered = MakeViewport(pixels, divisor).GetPixels(display);
      EXPECT_EQ(covered.Intersect(pixels), pixels);
      EXPECT_EQ(covered.Intersect(display), covered);
    }
  }
}

TEST(Viewport, OfNothingItIsEmpty)
{
  EXPECT_TRUE(CoverWithBlocks({ 5, 5, 0, 3 }, 4).IsEmpty());
  EXPECT_TRUE(MakeViewport({}, 1).GetPixels({ 0, 0, 10, 10 }).IsEmpty());
}
