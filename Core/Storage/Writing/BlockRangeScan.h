// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockRangeScan_h
#define isosurface_BlockRangeScan_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/ValueKey.h"
#include "Storage/Writing/BlockProfileScan.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// Finds the range of values at every block's own vertices on all ranks, of the first array or its
/// magnitude: what decides where blocks are stored.
class BlockRangeScan
{
public:
  BlockRangeScan(const BlockGrid& grid, ArrayVariables variables, int threads);

  /// Makes Scan() compute profiles as well.
  void AddProfiles();

  /// Reads this rank's vertices, the boxes `owned` of the source, once, in slabs of at least a row
  /// of vertices that take at most `memoryBytes`, with the one read ahead. Aborted if `progress`
  /// asked to stop.
  Status Scan(BoxSource& source, const std::vector<VertexBox>& owned, std::uint64_t memoryBytes,
    const Progress& progress);

  /// Collective. Joins the ranges of all ranks. Error of all ranks, which names `path`: OutOfMemory.
  Status Reduce(Communicator& communicator, const std::string& path);

  /// Per block.
  const std::vector<KeyRange>& GetRanges() const { return this->Ranges; }
  /// Per block; none without AddProfiles(). May be called once.
  std::vector<BlockProfile> TakeProfiles();

private:
  void AddSlab(const BoxSamples& slab, const VertexBox& box);
  void AddToProfiles(const BoxSamples& slab, const VertexBox& box);
  KeyRange FindRange(const BoxSamples& slab, const VertexBox& part) const;

  BlockGrid Grid;
  ArrayVariables Variables;
  int Threads;
  std::vector<KeyRange> Ranges;
  std::optional<BlockProfileScan> Profiles;
};

} // namespace isosurface

#endif
