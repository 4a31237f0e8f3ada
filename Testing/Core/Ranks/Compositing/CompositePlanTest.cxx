// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/CompositePlan.h"

#include "RandomImages.h"

#include <gtest/gtest.h>

#include <numeric>

using namespace isosurface;

namespace
{

/// Every pixel of every tile is in one cell of exactly the ranks whose viewports cover it.
void CheckCells(const std::vector<Viewport>& viewports, const std::vector<DisplayTile>& tiles)
{
  const std::vector<CompositeCell> cells = PlanCompositing(viewports, tiles);
  for (std::size_t tile = 0; tile < tiles.size(); ++tile)
  {
    const PixelRectangle& pixels = tiles[tile].Pixels;
    for (int y = pixels.Y; y < pixels.GetTop(); ++y)
    {
      for (int x = pixels.X; x < pixels.GetRight(); ++x)
      {
        std::vector<int> expected;
        for (std::size_t rank = 0; rank < viewports.size(); ++rank)
        {
          const int divisor = viewports[rank].Divisor;
          if (viewports[rank].Blocks.Contains(x / divisor, y / divisor))
          {
            expected.push_back(static_cast<int>(rank));
          }
        }
        std::vector<int> found;
        for (const CompositeCell& cell : cells)
        {
          if (cell.Tile == tile && cell.Pixels.Contains(x, y))
          {
            EXPECT_TRUE(found.empty()) << "two cells at " << x << ", " << y;
            found = cell.Ranks;
          }
        }
        ASSERT_EQ(found, expected) << "at " << x << ", " << y;
      }
    }
  }
  for (const CompositeCell& cell : cells)
  {
    EXPECT_EQ(cell.Pixels.Intersect(tiles[cell.Tile].Pixels), cell.Pixels);
    EXPECT_EQ(std::count(cell.Ranks.begin(), cell.Ranks.end(), cell.Owner), 1);
    int common = 0;
    for (const int rank : cell.Ranks)
    {
      common = std::gcd(common, viewports[static_cast<std::size_t>(rank)].Divisor);
    }
    EXPECT_EQ(cell.Divisor, common);
  }
}

} // namespace

TEST(CompositePlan, CellsAreWhereTheSameViewportsCoverATile)
{
  std::mt19937 random(3);
  const PixelRectangle display{ 0, 0, 61, 47 };
  for (int trial = 0; trial < 40; ++trial)
  {
    std::vector<Viewport> viewports;
    for (int rank = 0; rank < 2 + trial % 5; ++rank)
    {
      viewports.push_back(MakeViewport(
        MakeRandomRectangle(display, random), std::array<int, 4>{ 1, 2, 4, 6 }[random() % 4]));
    }
    CheckCells(viewports, { { display, 0 } });
    // A wall with a gap between its tiles, and one whose tiles overlap.
    CheckCells(viewports, { { { 0, 0, 30, 47 }, 0 }, { { 33, 0, 28, 47 }, 1 } });
    CheckCells(viewports, { { { 0, 0, 40, 47 }, 0 }, { { 25, 0, 36, 47 }, 1 } });
  }
}

TEST(CompositePlan, EqualNestedAndTouchingViewports)
{
  const PixelRectangle display{ 0, 0, 64, 64 };
  CheckCells({ MakeViewport(display, 1), MakeViewport(display, 1), MakeViewport(display, 4) },
    { { display, 0 } });
  CheckCells({ MakeViewport(display, 1), MakeViewport({ 20, 20, 20, 20 }, 2) }, { { display, 0 } });
  CheckCells(
    { MakeViewport({ 0, 0, 32, 64 }, 1), MakeViewport({ 32, 0, 32, 64 }, 1) }, { { display, 0 } });
}

TEST(CompositePlan, WithoutViewportsThereAreNoCells)
{
  EXPECT_TRUE(PlanCompositing({ {}, {} }, { { { 0, 0, 10, 10 }, 0 } }).empty());
  EXPECT_TRUE(PlanCompositing({ MakeViewport({ 0, 0, 9, 9 }, 1) }, {}).empty());
}

TEST(CompositePlan, WhereImagesMeetAllRanksHaveAboutEqualWork)
{
  const PixelRectangle display{ 0, 0, 1920, 1080 };
  for (const std::size_t ranks : { 2U, 3U, 8U, 16U })
  {
    const std::vector<Viewport> viewports(ranks, MakeViewport(display, 1));
    std::vector<double> pixels(ranks, 0);
    for (const CompositeCell& cell : PlanCompositing(viewports, { { display, 0 } }))
    {
      pixels[static_cast<std::size_t>(cell.Owner)] += static_cast<double>(cell.Pixels.GetArea());
    }
    // The rank that shows the tile has additional work, and owns less.
    const double maximum = *std::max_element(pixels.begin(), pixels.end());
    EXPECT_LT(maximum, 1.35 * static_cast<double>(display.GetArea()) / static_cast<double>(ranks));
    EXPECT_EQ(std::max_element(pixels.begin(), pixels.end()) == pixels.begin(), false) << ranks;
  }
}

TEST(CompositePlan, WhereOneRankDrawsAloneItOwnsTheCell)
{
  const std::vector<CompositeCell> cells =
    PlanCompositing({ MakeViewport({ 0, 0, 500, 400 }, 1), MakeViewport({ 500, 0, 500, 400 }, 2) },
      { { { 0, 0, 1000, 400 }, 0 } });
  ASSERT_EQ(cells.size(), 2U);
  EXPECT_EQ(cells[0].Owner, 0);
  EXPECT_EQ(cells[1].Owner, 1);
  EXPECT_EQ(cells[1].Divisor, 2);
}
