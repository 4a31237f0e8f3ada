// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockRangeScan_h
#define isosurface_BlockRangeScan_h

#include "Base/Communicator.h"
#include "Base/Progress.h"
#include "Store/BlockedVolumeWriter.h"
#include "Volume/BlockGrid.h"
#include "Volume/ValueKey.h"

#include <cstddef>
#include <vector>

namespace isosurface
{

/// The range of values of every block's own vertices, in every array, on all ranks.
class BlockRangeScan
{
public:
  /// Reads this rank's part of the vertices once; false if `progress` asked to stop. `owned` are
  /// boxes within the piece.
  bool Scan(const BlockGrid& grid, const VolumePiece& piece, const std::vector<VertexBox>& owned,
    std::size_t arrays, int threads, const Progress& progress);

  /// Collective: joins the ranges of all ranks.
  void Reduce(Communicator& communicator);

  /// Per array and block.
  const std::vector<std::vector<KeyRange>>& GetRanges() const { return this->Ranges; }
  /// Per array: of the whole volume's finite values.
  const std::vector<KeyRange>& GetFiniteRanges() const { return this->FiniteRanges; }

private:
  std::vector<std::vector<KeyRange>> Ranges;
  std::vector<KeyRange> FiniteRanges;
};

} // namespace isosurface

#endif
