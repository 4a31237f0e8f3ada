// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RoundPlan_h
#define isosurface_RoundPlan_h

#include "Ground/Volume/BlockGrid.h"
#include "Storage/Writing/SpanSamples.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Plans which rank makes the records of which blocks in which round; equal on all ranks. A round
/// is a span of blocks, divided among the ranks. So blocks come in the order of their indices, and
/// stores are written by appending records of any size.
class RoundPlan
{
public:
  /// `begin`: the first block that is planned.
  RoundPlan(const BlockGrid& grid, std::size_t ranks, std::int64_t begin);

  bool IsDone() const { return this->Next == this->Blocks; }
  /// How many blocks are planned, with those before the first one.
  std::int64_t GetCount() const { return this->Next; }

  /// The spans of the next round, one for each rank, of at most `blocks` (> 0) blocks: whole layers
  /// of blocks, whole rows, or parts of a row, so that few samples are read twice.
  std::vector<BlockSpan> Propose(std::int64_t blocks) const;
  /// Continues after these spans.
  void Take(const std::vector<BlockSpan>& spans);

private:
  BlockSpan CutSpan(std::int64_t begin, std::int64_t blocks) const;

  std::size_t Ranks;
  std::int64_t Row;
  std::int64_t Layer;
  std::int64_t Blocks;
  std::int64_t Next;
};

} // namespace isosurface

#endif
