// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockRanges_h
#define isosurface_BlockRanges_h

#include "Base/Progress.h"
#include "Base/Status.h"
#include "Volume/BlockGrid.h"
#include "Volume/SampleView.h"
#include "Volume/ValueKey.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * The range of values in each block of some samples in memory: which blocks an isovalue crosses.
 * Computed once an array, it serves every isovalue.
 *
 * The samples' Box is cut from its own low corner into blocks of 32 cells a side, as BlockGrid
 * does; a block's range covers all of its vertices. Cost: one pass over the samples; 16 bytes of
 * memory a block.
 */
class BlockRanges
{
public:
  static constexpr int BlockSize = 32;

  BlockRanges() = default;

  /// Reads every sample of samples.Box once, on `threads` threads. Errors: Aborted.
  static Result<BlockRanges> Compute(
    const SampleView& samples, int threads, const Progress& progress = {});

  /// The blocks, counted from the low corner of the Box.
  const BlockGrid& GetGrid() const { return this->Grid; }
  const KeyRange& GetRange(std::int64_t block) const
  {
    return this->Ranges[static_cast<std::size_t>(block)];
  }

  /// The blocks that at least one of the isovalues crosses, ascending.
  std::vector<std::int64_t> FindActiveBlocks(const std::vector<double>& isovalues) const;

  /// The blocks of which all samples are inside for at least one of the isovalues, ascending.
  std::vector<std::int64_t> FindInsideBlocks(const std::vector<double>& isovalues) const;

private:
  template <typename Predicate>
  std::vector<std::int64_t> FindBlocks(
    const std::vector<double>& isovalues, const Predicate& isWanted) const;

  ValueType Type = ValueType::UInt8;
  BlockGrid Grid;
  std::vector<KeyRange> Ranges;
};

} // namespace isosurface

#endif
