// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockAssembly_h
#define isosurface_BlockAssembly_h

#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/QueryStatistics.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace isosurface
{

/// A box of whole blocks, [Low, High) in block coordinates: the piece of a volume that one rank of
/// several gets if neighbours stay together, whatever stores they are in.
struct BlockBox
{
  Index3 Low{ 0, 0, 0 };
  Index3 High{ 0, 0, 0 };

  bool IsEmpty() const;
  bool Contains(const Index3& block) const;

  /// The vertices of the box's own cells at a level of the blocks' records (StoredLevel::Level);
  /// the same with the ghost layer.
  VertexBox GetVertices(const BlockGrid& grid, int level) const;
  VertexBox GetGhostedVertices(const BlockGrid& grid, int level) const;
};

/// The slab of a piece: the layers of blocks along the axis with the maximum number of them are
/// divided evenly. With more pieces than layers some are empty.
BlockBox PartitionBlocks(const BlockGrid& grid, int piece, int pieces);

/// The finest level at which the largest of `pieces` pieces (PartitionBlocks) of these arrays takes at
/// most `bytes` of memory, by BlockedVolume::EstimateBytes; nothing if not even the coarsest level does.
std::optional<int> FindLevelWithin(const BlockedVolume& volume,
  const std::vector<std::size_t>& arrays, int pieces, std::uint64_t bytes);

/**
 * Fills `samples` with one variable in a box of blocks at a level of the volume, x fastest, at the
 * vertices of GetGhostedVertices. Successive vertices are `stride` samples apart, so that the
 * components of an array can be interleaved. `box` and `blocks` (those of the box, in any order)
 * are of the grid that has the level (BlockedVolume::FindLevel).
 *
 * Every block is read once, through the block cache, on `threads` threads; the ghost layer comes
 * from those of the box's own blocks. Errors: of ReadBlock; Aborted.
 */
Status AssembleBlocks(BlockedVolume& volume, std::size_t timeStep, std::size_t variable, int level,
  const BlockBox& box, const std::vector<BlockReference>& blocks, int threads, void* samples,
  std::ptrdiff_t stride, QueryStatistics& statistics, const Progress& progress = {});

/// Takes the samples of a block; called by several threads at once.
using BlockVisitor = std::function<void(const BlockReference&, const SampleView&)>;

/// Calls `visit` with one variable of each block, which is read once, through the block cache, on
/// `threads` threads. Errors: of ReadBlock; Aborted.
Status VisitBlocks(BlockedVolume& volume, std::size_t timeStep, std::size_t variable, int level,
  const std::vector<BlockReference>& blocks, int threads, const BlockVisitor& visit,
  QueryStatistics& statistics, const Progress& progress = {});

/// A step of a number of steps, with the statistics of its thread.
using ReadingStep = std::function<Status(std::size_t index, QueryStatistics& statistics)>;

/// Calls `step` for each index in [0, count), on `threads` threads. Errors: the first one of a step,
/// after which no other one begins; Aborted.
Status ReadInParallel(std::size_t count, int threads, const ReadingStep& step,
  QueryStatistics& statistics, const Progress& progress = {});

} // namespace isosurface

#endif
