// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockRangeScan_h
#define isosurface_BlockRangeScan_h

#include "Base/Communicator.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Source/SlabSource.h"
#include "Volume/SampleRange.h"
#include "Volume/BlockGrid.h"
#include "Volume/ValueKey.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// The range of values of every block's own vertices, in every array, on all ranks.
class BlockRangeScan
{
public:
  BlockRangeScan(const BlockGrid& grid, std::vector<ValueType> types, int threads);

  /// Reads this rank's part of the vertices once, in slabs that take at most `memoryBytes` (the
  /// one being read ahead included), but a row of vertices at least. `owned` are boxes within the
  /// source's. Aborted if `progress` asked to stop.
  Status Scan(SlabSource& source, const std::vector<VertexBox>& owned, std::uint64_t memoryBytes,
    const Progress& progress);

  /// Collective: joins the ranges of all ranks.
  void Reduce(Communicator& communicator);

  /// Per array and block.
  const std::vector<std::vector<KeyRange>>& GetRanges() const { return this->Ranges; }
  /// Per array: of the whole volume's finite values.
  const std::vector<KeyRange>& GetFiniteRanges() const { return this->FiniteRanges; }

private:
  void AddSlab(const SampleSlab& slab, const VertexBox& box);

  BlockGrid Grid;
  std::vector<ValueType> Types;
  int Threads;
  std::vector<std::vector<KeyRange>> Ranges;
  std::vector<KeyRange> FiniteRanges;
};

} // namespace isosurface

#endif
