// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/VertexBox.h"

#include <gtest/gtest.h>

#include <vector>

using namespace isosurface;

namespace
{

// Says of each vertex of a grid whether a box has it.
std::vector<bool> MarkVertices(const VertexBox& box, const Index3& dimensions)
{
  std::vector<bool> marks;
  for (std::int64_t k = 0; k < dimensions[2]; ++k)
  {
    for (std::int64_t j = 0; j < dimensions[1]; ++j)
    {
      for (std::int64_t i = 0; i < dimensions[0]; ++i)
      {
        marks.push_back(i >= box.Low[0] && i < box.High[0] && j >= box.Low[1] && j < box.High[1] &&
          k >= box.Low[2] && k < box.High[2]);
      }
    }
  }
  return marks;
}

constexpr Index3 Dimensions{ 5, 4, 3 };

TEST(VertexBox, ALayerIsAddedWhereTheGridHasOne)
{
  const VertexBox inner{ { 1, 1, 1 }, { 3, 2, 2 } };
  EXPECT_EQ(inner.AddLayer(Dimensions), (VertexBox{ { 0, 0, 0 }, { 4, 3, 3 } }));
  const VertexBox whole{ { 0, 0, 0 }, Dimensions };
  EXPECT_EQ(whole.AddLayer(Dimensions), whole);
  const VertexBox known{ { 1, 0, 1 }, { 5, 4, 2 } };
  EXPECT_EQ(inner.AddLayer(known), (VertexBox{ { 1, 0, 1 }, { 4, 3, 2 } }));
}

TEST(VertexBox, ContainsBoxesWithoutVerticesOutside)
{
  const VertexBox box{ { 1, 1, 0 }, { 4, 3, 2 } };
  EXPECT_TRUE(box.Contains(box));
  EXPECT_TRUE(box.Contains({ { 2, 1, 1 }, { 4, 2, 2 } }));
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    VertexBox low = box;
    --low.Low[axis];
    EXPECT_FALSE(box.Contains(low)) << axis;
    VertexBox high = box;
    ++high.High[axis];
    EXPECT_FALSE(box.Contains(high)) << axis;
  }
}

TEST(VertexBox, VisitsEachVertexOnceXFastest)
{
  const VertexBox grid{ { 0, 0, 0 }, Dimensions };
  const VertexBox box{ { 1, 0, 1 }, { 4, 3, 3 } };
  std::vector<bool> visited(grid.GetNumberOfVertices(), false);
  std::size_t count = 0;
  VisitVertices(box,
    [&](const Index3& vertex)
    {
      EXPECT_EQ(box.FindIndex(vertex), count++);
      visited[grid.FindIndex(vertex)] = true;
    });
  EXPECT_EQ(visited, MarkVertices(box, Dimensions));
  std::vector<bool> ofRows(grid.GetNumberOfVertices(), false);
  VisitRows(box,
    [&](const Index3& first, std::int64_t size)
    {
      for (std::int64_t i = 0; i < size; ++i)
      {
        ofRows[grid.FindIndex(first) + static_cast<std::size_t>(i)] = true;
      }
    });
  EXPECT_EQ(ofRows, visited);
}

TEST(VertexBox, AnEmptyBoxHasNothingToVisit)
{
  VisitVertices({ { 2, 2, 2 }, { 2, 3, 3 } }, [](const Index3&) { FAIL(); });
}

TEST(VertexBox, ComesBackFromAMessageAsItWas)
{
  const std::vector<VertexBox> boxes = { { { -3, 0, 1 }, { 1ll << 40, 2, 3 } }, {} };
  std::vector<std::uint8_t> message;
  for (const VertexBox& box : boxes)
  {
    AppendBox(message, box);
  }
  ASSERT_EQ(message.size(), boxes.size() * 6 * sizeof(std::int64_t));
  EXPECT_EQ(message[0], 0xfd); // the low byte comes first
  ByteReader reader(message);
  for (const VertexBox& box : boxes)
  {
    EXPECT_EQ(ReadBox(reader), box);
  }
  EXPECT_EQ(reader.GetRemaining(), 0u);
}

} // namespace
