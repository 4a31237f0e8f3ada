// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockSegment_h
#define isosurface_BlockSegment_h

#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/SampleCopy.h"

#include <algorithm>
#include <cstdint>

namespace isosurface
{

/// Consecutive samples of a segment: those of the vertices (I + n * Step, J, K), n < Count.
struct SegmentRow
{
  std::int64_t I;
  std::int64_t J;
  std::int64_t K;
  std::int64_t Step;
  std::int64_t Count;
  std::uint64_t Offset; ///< of the first sample in the segment, in samples
};

/**
 * Which vertices of a block the segment of one level lists, and in which order.
 *
 * The segment of level l lists, in raster order, the vertices of the level's ghosted box that level
 * l + 1 does not have: those with an odd coordinate. Blocks begin and end at even vertices of each
 * level but the coarsest, or at the end of the volume, so ghost vertices always have an odd one.
 * The coarsest level lists its whole box. So each level has a ghost layer of its own, at its own
 * spacing, and a block at level l needs the segments from the coarsest level to l:
 *
 *     level 1 (coarsest here)   G . O . O . G          O own vertex, G ghost vertex
 *     level 0                   . g o - o - o g .      o, g listed here; - taken from level 1
 */
class BlockSegment
{
public:
  BlockSegment(const BlockGrid& grid, std::int64_t block, int level)
    : Box(grid.GetGhostedVertices(block, level))
    , OwnBox(grid.GetVertices(block, level))
    , IsWhole(level == grid.GetNumberOfLevels() - 1)
  {
  }

  /// The level's vertices of the block with its ghost layer, in the level's coordinates.
  const VertexBox& GetBox() const { return this->Box; }
  /// The same without the ghost layer.
  const VertexBox& GetOwnBox() const { return this->OwnBox; }
  std::uint64_t GetNumberOfSamples() const;

  /// Calls visit(SegmentRow) for the segment's samples within `part`, row by row, in order.
  template <typename Visitor>
  void VisitRows(const VertexBox& part, Visitor&& visit) const
  {
    std::uint64_t rowBegin = 0;
    for (std::int64_t k = this->Box.Low[2]; k < std::min(part.High[2], this->Box.High[2]); ++k)
    {
      for (std::int64_t j = this->Box.Low[1]; j < this->Box.High[1]; ++j)
      {
        const std::int64_t step = this->IsWhole || ((j | k) & 1) != 0 ? 1 : 2;
        const std::int64_t begin = AlignUp(this->Box.Low[0], step);
        if (k >= part.Low[2] && j >= part.Low[1] && j < part.High[1])
        {
          const std::int64_t first = AlignUp(std::max(this->Box.Low[0], part.Low[0]), step);
          const std::int64_t count =
            CountSteps(first, std::min(this->Box.High[0], part.High[0]), step);
          if (count > 0)
          {
            visit(SegmentRow{ first, j, k, step, count,
              rowBegin + static_cast<std::uint64_t>((first - begin) / step) });
          }
        }
        rowBegin += static_cast<std::uint64_t>(CountSteps(begin, this->Box.High[0], step));
      }
    }
  }

private:
  /// The first vertex >= low that a row of this step lists: `low` itself, or the next odd one.
  static std::int64_t AlignUp(std::int64_t low, std::int64_t step)
  {
    return step == 1 ? low : low | 1;
  }
  static std::int64_t CountSteps(std::int64_t first, std::int64_t end, std::int64_t step)
  {
    return first < end ? (end - first + step - 1) / step : 0;
  }

  VertexBox Box;
  VertexBox OwnBox;
  bool IsWhole;
};

/// The vertices of a level within a box of level 0, in the level's coordinates; it may be empty.
VertexBox CoarsenBox(const VertexBox& box, int level);

} // namespace isosurface

#endif
