// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/PieceOwnership.h"

#include <gtest/gtest.h>

#include <random>

using namespace isosurface;

TEST(PieceOwnership, EveryVertexOfTheUnionBelongsToOneRankWhosePieceHasIt)
{
  std::mt19937 random(3);
  const auto pick = [&](std::int64_t size)
  {
    const auto a = static_cast<std::int64_t>(random() % static_cast<unsigned>(size + 1));
    const auto b = static_cast<std::int64_t>(random() % static_cast<unsigned>(size + 1));
    return std::make_pair(std::min(a, b), std::max(a, b));
  };
  for (int trial = 0; trial < 300; ++trial)
  {
    std::vector<VertexBox> pieces;
    for (std::size_t rank = 0; rank < 1 + random() % 6; ++rank)
    {
      VertexBox box;
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        std::tie(box.Low[axis], box.High[axis]) = pick(9);
      }
      // Some pieces are the same on several ranks.
      pieces.push_back(!pieces.empty() && random() % 3 == 0 ? pieces.back() : box);
    }
    std::vector<int> owners(9 * 9 * 9, 0);
    std::vector<int> holders(9 * 9 * 9, 0);
    const auto fill = [](std::vector<int>& counts, const VertexBox& box)
    {
      VisitVertices(box,
        [&](const Index3& vertex)
        {
          const auto [i, j, k] = vertex;
          ++counts[static_cast<std::size_t>(i + 9 * (j + 9 * k))];
        });
    };
    for (std::size_t rank = 0; rank < pieces.size(); ++rank)
    {
      fill(holders, pieces[rank]);
      for (const VertexBox& box : FindOwnedBoxes(pieces, rank))
      {
        ASSERT_EQ(pieces[rank].Intersect(box), box);
        fill(owners, box);
      }
    }
    for (std::size_t vertex = 0; vertex < owners.size(); ++vertex)
    {
      ASSERT_EQ(owners[vertex], holders[vertex] > 0 ? 1 : 0);
    }

    // Each vertex of a box is supplied by the first piece that has it, or is missing.
    std::vector<VertexBox> missing = { { { 1, 0, 2 }, { 8, 9, 6 } } };
    std::vector<int> supplied(owners.size(), 0);
    for (const Supply& supply : FindSupplies(pieces, missing))
    {
      ASSERT_TRUE(pieces[supply.Piece].Contains(supply.Box));
      for (std::size_t before = 0; before < supply.Piece; ++before)
      {
        ASSERT_TRUE(pieces[before].Intersect(supply.Box).IsEmpty());
      }
      fill(supplied, supply.Box);
    }
    for (const VertexBox& box : missing)
    {
      fill(supplied, box);
    }
    ASSERT_EQ(std::count(supplied.begin(), supplied.end(), 1), 7 * 9 * 4);
    ASSERT_EQ(std::count(supplied.begin(), supplied.end(), 0), 9 * 9 * 9 - 7 * 9 * 4);
  }
}

TEST(PieceOwnership, RanksWithTheSamePieceDivideItEvenly)
{
  const std::vector<VertexBox> pieces(4, { { 0, 0, 0 }, { 10, 10, 40 } });
  for (std::size_t rank = 0; rank < pieces.size(); ++rank)
  {
    const auto owned = FindOwnedBoxes(pieces, rank);
    ASSERT_EQ(owned.size(), 1u);
    EXPECT_EQ(owned[0].GetNumberOfVertices(), 1000);
  }
}
