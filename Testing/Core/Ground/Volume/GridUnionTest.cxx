// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/GridUnion.h"

#include "Fixtures/Require.h"
#include "Fixtures/ThreadCommunicator.h"

#include <gtest/gtest.h>

#include <array>

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

TEST(GridUnion, PiecesOfOneFrameBecomeOneGridOnAllRanks)
{
  const std::vector<std::vector<GridGeometry>> pieces = {
    { MakePiece(7, { 0, 4, 0, 9, -3, 2 }), MakePiece(1, { 5, 6, 5, 6, 5, 6 }) },
    {},
    { MakePiece(7, { 4, 11, -2, 3, 0, 1 }) },
  };
  ThreadCommunicator::Run(3,
    [&](Communicator& ranks)
    {
      const auto grids =
        Require(UniteGrids(ranks, pieces[static_cast<std::size_t>(ranks.GetRank())]));
      ASSERT_EQ(grids.size(), 2U);
      EXPECT_EQ(grids[0], MakePiece(1, { 5, 6, 5, 6, 5, 6 }));
      EXPECT_EQ(grids[1], MakePiece(7, { 0, 11, -2, 9, -3, 2 }));
      EXPECT_EQ(FindGrid(grids, pieces[2][0]), 1U);
      EXPECT_EQ(FindGrid(grids, pieces[0][1]), 0U);
    });
}

TEST(GridUnion, NoPiecesAreNoGrids)
{
  ThreadCommunicator::Run(
    2, [](Communicator& ranks) { EXPECT_TRUE(Require(UniteGrids(ranks, {})).empty()); });
}
