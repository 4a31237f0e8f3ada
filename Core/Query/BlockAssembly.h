// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockAssembly_h
#define isosurface_BlockAssembly_h

#include "Base/Progress.h"
#include "Base/Status.h"
#include "Store/BlockedVolume.h"
#include "Store/QueryStatistics.h"
#include "Volume/BlockGrid.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace isosurface
{

/**
 * A box of whole blocks, [Low, High) in block coordinates: the part of a volume that one piece of
 * several gets when neighbours are to stay together, whatever stores they are in.
 */
struct BlockBox
{
  Index3 Low{ 0, 0, 0 };
  Index3 High{ 0, 0, 0 };

  bool IsEmpty() const;
  bool Contains(const Index3& block) const;

  /// The vertices of the box's own cells at a level of the blocks' records (StoredLevel::Level),
  /// and those with the ghost layer around them.
  VertexBox GetVertices(const BlockGrid& grid, int level) const;
  VertexBox GetGhostedVertices(const BlockGrid& grid, int level) const;
};

/// The slab of a piece: pieces of equally many layers of blocks along the axis that has most of
/// them. With more pieces than layers some are empty.
BlockBox PartitionBlocks(const BlockGrid& grid, int piece, int pieces);

/// The finest level at which one of `pieces` equal pieces of these arrays takes at most `bytes` of
/// memory, by BlockedVolume::EstimateBytes; nothing if not even the coarsest level does.
std::optional<int> FindLevelWithin(const BlockedVolume& volume,
  const std::vector<std::size_t>& arrays, int pieces, std::uint64_t bytes);

/**
 * Fills `samples` with one variable in a box of blocks at a level of the volume, ghost layer
 * included, x fastest: the vertices of GetGhostedVertices. A vertex and the next one are `stride`
 * samples apart, so that the components of an array can be put between each other. `box` counts,
 * and `blocks` are, in any order, blocks of those that have the level (BlockedVolume::FindLevel).
 *
 * Every block is read once, through the block cache, on `threads` threads; the ghost layer comes
 * from the ghost layers of the box's own blocks. Errors: of ReadBlock; Aborted.
 */
Status AssembleBlocks(BlockedVolume& volume, std::size_t timeStep, std::size_t variable, int level,
  const BlockBox& box, const std::vector<BlockReference>& blocks, int threads, void* samples,
  std::ptrdiff_t stride, QueryStatistics& statistics, const Progress& progress = {});

} // namespace isosurface

#endif
