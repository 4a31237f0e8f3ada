// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/GridUnion.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

using namespace isosurface;

namespace
{

GridGeometry MakePiece(double originX, const std::array<std::int64_t, 6>& extent)
{
  GridGeometry piece;
  piece.Origin = { originX, 2, 3 };
  piece.Spacing = { 0.5, 1, 2 };
  piece.Extent = extent;
  return piece;
}

} // namespace

TEST(GridUnion, PiecesOfOneFrameOnAllRanksBecomeOneGrid)
{
  const std::vector<std::vector<GridGeometry>> pieces = {
    { MakePiece(7, { 0, 4, 0, 9, -3, 2 }), MakePiece(1, { 5, 6, 5, 6, 5, 6 }) },
    {},
    { MakePiece(7, { 4, 11, -2, 3, 0, 1 }) },
  };
  std::vector<Message> packed;
  for (const std::vector<GridGeometry>& ofRank : pieces)
  {
    packed.push_back(PackGrids(ofRank));
  }
  const auto grids = UniteGrids(packed);
  ASSERT_EQ(grids.size(), 2U);
  EXPECT_EQ(grids[0], MakePiece(1, { 5, 6, 5, 6, 5, 6 }));
  EXPECT_EQ(grids[1], MakePiece(7, { 0, 11, -2, 9, -3, 2 }));
  EXPECT_EQ(FindGrid(grids, pieces[2][0]), 1U);
  EXPECT_EQ(FindGrid(grids, pieces[0][1]), 0U);
}

TEST(GridUnion, NoPiecesAreNoGrids)
{
  EXPECT_TRUE(UniteGrids({ PackGrids({}), PackGrids({}) }).empty());
}
