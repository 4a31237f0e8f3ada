// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CompactPartition_h
#define isosurface_CompactPartition_h

#include "Volume/BlockGrid.h"

#include <array>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// A block, and how much work its surface is, in whatever unit: its points or triangles, say.
struct WeighedBlock
{
  VertexBox Vertices;
  std::uint64_t Workload = 0;
};

/**
 * The part, of `parts`, of every block, such that the parts are near each other in work and the
 * blocks of a part are near each other in space: each part has a small bounding box, and boxes of
 * different parts overlap by at most about a layer of blocks. parts >= 1; some are empty if there
 * are fewer blocks. No two blocks have the same low vertex; `spacing` is that of the grid.
 *
 * Recursive coordinate bisection (M. Berger and S. Bokhari, "A partitioning strategy for nonuniform
 * problems on multiprocessors", 1987): blocks are sorted along the longest side of their bounding
 * box and cut in two runs, for floor(parts / 2) parts and the rest, where the greater of the two
 * runs' mean work of a part is least. Blocks of the same place on that side are sorted along the
 * others, so that a cut can pass within a layer. Deviation: the cut goes by work, not by number.
 *
 * No part has more work than the mean and 1.3 times the heaviest block: a cut among n parts raises
 * the mean by at most a block's work / n, and n is at least 2, 3, 5, 9 ... from the last cut up.
 *
 * Depends on the set of blocks alone, not on their order, so all ranks that know it find the same.
 * Cost: a sort of all blocks for every doubling of the parts; memory 12 bytes a block.
 */
std::vector<std::uint32_t> MakeCompactPartition(const std::vector<WeighedBlock>& blocks,
  std::uint32_t parts, const std::array<double, 3>& spacing);

} // namespace isosurface

#endif
