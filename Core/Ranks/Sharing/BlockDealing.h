// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockDealing_h
#define isosurface_BlockDealing_h

#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/GridGeometry.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Predicts the triangles of active blocks, up to a factor, from nothing but which blocks are active. A
 * surface that crosses a face of a block makes the block behind it active, too; so a block whose
 * neighbours are active on both sides of two axes has a sheet through its middle, and one with few
 * active neighbours has a corner cut off. The weights are a fit to 52 isosurfaces of eleven volumes
 * (Documentation/dev/load-balance.md); the prediction correlates with the triangles at 0.56.
 *
 * `blocks`: numbers in the grid, ascending. The result is positive. Cost: 26 look-ups a block in a
 * bit map of the box around the blocks; where that had more than 2^28 bits, all have equal work.
 */
std::vector<std::int64_t> PredictActiveBlockWork(
  const BlockGrid& grid, const std::vector<std::int64_t>& blocks);

/**
 * Deals the blocks of a grid to ranks so that each rank has equally many in every part of space: the
 * blocks of a rank are a lattice, whose nearest neighbours are as far from each other as possible.
 * So the active blocks of any isovalue, and their triangles, fall to all ranks evenly. A block has
 * the same rank at all isovalues and wherever it is stored, so block caches stay warm, and no rank
 * needs a message from another one.
 *
 * Active blocks of an isovalue that are nevertheless uneven are evened out: ranks with too much
 * predicted work give a few blocks to others.
 */
class BlockDealing
{
public:
  /// Cost: some milliseconds at most.
  explicit BlockDealing(std::uint32_t ranks);

  /// The rank of a block, by its coordinates in the grid of blocks.
  std::uint32_t FindRank(const Index3& block) const
  {
    return static_cast<std::uint32_t>(
      (block[0] + this->StepY * block[1] + this->StepZ * block[2]) % this->Ranks);
  }

  /**
   * The ranks of all active blocks, in the order of these; `blocks` are their numbers in the grid.
   * Nearly all have that of FindRank; which others depends on the set of blocks alone, not on their
   * order. Integers only, so every machine finds the same. Cost: sorting the blocks, and that of
   * PredictActiveBlockWork.
   */
  std::vector<std::uint32_t> Deal(
    const BlockGrid& grid, const std::vector<std::int64_t>& blocks) const;

private:
  std::int64_t Ranks;
  std::int64_t StepY = 1; ///< how many ranks on the next block on y is
  std::int64_t StepZ = 1;
};

} // namespace isosurface

#endif
