// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RoundPlan_h
#define isosurface_RoundPlan_h

#include "Volume/BlockGrid.h"
#include "Writing/RunSamples.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Which rank makes the records of which blocks in which round. The same on all ranks.
 *
 * A round is a run of blocks that is shared out among the ranks, so blocks come in the order of
 * their indices: a store can be written by appending, whatever its records' sizes turn out to be.
 */
class RoundPlan
{
public:
  RoundPlan(const BlockGrid& grid, std::size_t ranks);

  bool IsDone() const { return this->Next == this->Blocks; }
  /// How many blocks are planned.
  std::int64_t GetCount() const { return this->Next; }

  /// The runs of the next round, a rank each, of at most `blocks` (> 0) blocks. Whole layers of
  /// blocks, whole rows or parts of one, so that little is read twice.
  std::vector<BlockRun> Propose(std::int64_t blocks) const;
  /// Goes on to the round after these.
  void Take(const std::vector<BlockRun>& runs);

private:
  BlockRun CutRun(std::int64_t begin, std::int64_t blocks) const;

  std::size_t Ranks;
  std::int64_t Row;
  std::int64_t Layer;
  std::int64_t Blocks;
  std::int64_t Next = 0;
};

} // namespace isosurface

#endif
