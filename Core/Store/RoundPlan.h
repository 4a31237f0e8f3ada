// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RoundPlan_h
#define isosurface_RoundPlan_h

#include "Store/RunSamples.h"
#include "Volume/BlockGrid.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Which rank makes the records of which blocks in which round. The same on all ranks.
 *
 * If every rank can read the whole volume, a round is a run of blocks that is shared out among the
 * ranks, so that blocks come in the order of their indices: one lane. If each has a part of its
 * own, the blocks are cut into a lane a rank, which go on side by side: so all ranks' parts are
 * asked for at the same time, whatever their number.
 */
class RoundPlan
{
public:
  RoundPlan(const BlockGrid& grid, std::size_t ranks, bool isShared);

  /// The blocks of a lane, in whose order they come.
  const std::vector<BlockRun>& GetLanes() const { return this->Lanes; }
  std::size_t FindLane(std::int64_t block) const;

  bool IsDone() const;
  /// How many blocks are planned.
  std::int64_t GetCount() const { return this->Count; }

  /// The runs of the next round, a rank each, of at most `blocks` (> 0) blocks. Whole layers of
  /// blocks, whole rows or parts of one, so that little is read twice.
  std::vector<BlockRun> Propose(std::int64_t blocks) const;
  /// Goes on to the round after these.
  void Take(const std::vector<BlockRun>& runs);

private:
  BlockRun CutRun(std::int64_t begin, std::int64_t end, std::int64_t blocks) const;

  std::size_t Ranks;
  std::int64_t Row;
  std::int64_t Layer;
  std::vector<BlockRun> Lanes;
  std::vector<std::int64_t> Next; ///< per lane
  std::int64_t Count = 0;
};

} // namespace isosurface

#endif
