// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CompactPartition_h
#define isosurface_CompactPartition_h

#include "Ground/Volume/BlockGrid.h"

#include <array>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// A block and the work of its surface, in any unit: points or triangles, for example.
struct WeighedBlock
{
  VertexBox Vertices;
  std::uint64_t Workload = 0;
};

/**
 * Assigns blocks to `pieces` pieces (at least 1) of about equal work, each compact in space:
 * bounding boxes of different pieces overlap by at most about a layer of blocks. Returns the piece
 * of each block; with fewer blocks than pieces some pieces are empty. No two blocks have the same
 * low vertex; spacing: that of the grid.
 *
 * Recursive coordinate bisection: M. Berger and S. Bokhari, "A partitioning strategy for nonuniform
 * problems on multiprocessors", 1987. Deviation: cuts balance work, not numbers, and may lie within a
 * layer of blocks. No piece has more work than the mean plus 1.3 times the heaviest block.
 *
 * The result depends on the set of blocks, not on their order. Cost: a sort of all blocks for each
 * doubling of the pieces; 12 bytes for each block.
 */
std::vector<std::uint32_t> MakeCompactPartition(const std::vector<WeighedBlock>& blocks,
  std::uint32_t pieces, const std::array<double, 3>& spacing);

} // namespace isosurface

#endif
