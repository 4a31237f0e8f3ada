// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/BlockSegment.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <vector>

using namespace isosurface;

namespace
{

bool Contains(const VertexBox& box, const Index3& vertex)
{
  bool inside = true;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    inside = inside && vertex[axis] >= box.Low[axis] && vertex[axis] < box.High[axis];
  }
  return inside;
}

/// The oracle, straight from the definition.
std::vector<Index3> ListVertices(const BlockGrid& grid, std::int64_t block, int level)
{
  const VertexBox box = grid.GetGhostedVertices(block, level);
  const VertexBox own = grid.GetVertices(block, level);
  const bool isCoarsest = level + 1 == grid.GetNumberOfLevels();
  std::vector<Index3> vertices;
  VisitVertices(box,
    [&](const Index3& vertex)
    {
      const auto [i, j, k] = vertex;
      const bool isCoarser = i % 2 == 0 && j % 2 == 0 && k % 2 == 0;
      if (isCoarsest || !isCoarser || !Contains(own, vertex))
      {
        vertices.push_back(vertex);
      }
    });
  return vertices;
}

} // namespace

TEST(BlockSegment, ListsTheVerticesThatNoCoarserLevelHas)
{
  for (const Index3& size : { Index3{ 1, 1, 1 }, Index3{ 40, 33, 18 }, Index3{ 17, 2, 35 } })
  {
    const BlockGrid grid(size, 16);
    for (std::int64_t block = 0; block < grid.GetNumberOfBlocks(); ++block)
    {
      for (int level = 0; level < grid.GetNumberOfLevels(); ++level)
      {
        const BlockSegment segment(grid, block, level);
        const std::vector<Index3> expected = ListVertices(grid, block, level);
        std::vector<Index3> listed;
        segment.VisitRows(segment.GetBox(),
          [&](const SegmentRow& row)
          {
            ASSERT_EQ(row.Offset, listed.size());
            for (std::int64_t n = 0; n < row.Count; ++n)
            {
              listed.push_back({ row.I + n * row.Step, row.J, row.K });
            }
          });
        ASSERT_EQ(listed, expected);
        ASSERT_EQ(segment.GetNumberOfSamples(), expected.size());
      }
    }
  }
}

TEST(BlockSegment, VisitsAPartWithTheOffsetsOfTheWhole)
{
  const BlockGrid grid({ 40, 33, 18 }, 16);
  const std::int64_t block = grid.GetBlockIndex({ 1, 1, 0 });
  for (int level = 0; level < grid.GetNumberOfLevels(); ++level)
  {
    const BlockSegment segment(grid, block, level);
    const std::vector<Index3> expected = ListVertices(grid, block, level);
    const VertexBox& box = segment.GetBox();
    for (int shift = 0; shift < 5; ++shift)
    {
      const VertexBox part{ { box.Low[0] + shift, box.Low[1] + 1, box.Low[2] },
        { box.High[0] - 1, box.High[1] + 3, box.High[2] - shift } };
      std::size_t visited = 0;
      segment.VisitRows(part,
        [&](const SegmentRow& row)
        {
          for (std::int64_t n = 0; n < row.Count; ++n)
          {
            const Index3 vertex{ row.I + n * row.Step, row.J, row.K };
            ASSERT_TRUE(Contains(part, vertex));
            ASSERT_EQ(expected[row.Offset + static_cast<std::size_t>(n)], vertex);
            ++visited;
          }
        });
      std::size_t inPart = 0;
      for (const Index3& vertex : expected)
      {
        inPart += Contains(part, vertex);
      }
      EXPECT_EQ(visited, inPart);
    }
  }
}

TEST(BlockSegment, CoarsensABoxToTheVerticesOfALevel)
{
  EXPECT_EQ(CoarsenBox({ { 0, 1, 8 }, { 9, 8, 9 } }, 3), (VertexBox{ { 0, 1, 1 }, { 2, 1, 2 } }));
}

TEST(CopySamples, CopiesEverySizeWithAnyStride)
{
  std::array<std::uint8_t, 120> from;
  std::iota(from.begin(), from.end(), std::uint8_t{ 1 });
  for (const std::size_t size : { 1, 2, 4, 8 })
  {
    for (const std::ptrdiff_t toStride : { 1, 2 })
    {
      for (const std::ptrdiff_t fromStride : { 1, 3 })
      {
        std::array<std::uint8_t, 120> to{};
        CopySamples(to.data(), toStride, from.data(), fromStride, 5, size);
        for (std::size_t byte = 0; byte < to.size(); ++byte)
        {
          const std::size_t sample = byte / size / static_cast<std::size_t>(toStride);
          const bool isCopied = byte / size % static_cast<std::size_t>(toStride) == 0 && sample < 5;
          const std::size_t source =
            sample * static_cast<std::size_t>(fromStride) * size + byte % size;
          EXPECT_EQ(to[byte], isCopied ? from[source] : 0);
        }
      }
    }
  }
}
