// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockRanges_h
#define isosurface_BlockRanges_h

#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/SampleView.h"
#include "Ground/Volume/ValueKey.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * The value range of each block of samples in memory, to find the active blocks. Computed once for
 * an array, and used for every isovalue.
 *
 * The samples' Box is cut into blocks of 32 cells a side, from its low corner, as BlockGrid does.
 * The range of a block covers all of its vertices. Cost: one pass over the samples. Memory: 16
 * bytes a block.
 */
class BlockRanges
{
public:
  static constexpr int BlockSize = 32;

  BlockRanges() = default;

  /// Reads the samples of the Box on `threads` threads. Errors: Aborted.
  static Result<BlockRanges> Compute(
    const SampleView& samples, int threads, const Progress& progress = {});

  /// The blocks, counted from the low corner of the Box.
  const BlockGrid& GetGrid() const { return this->Grid; }
  const KeyRange& GetRange(std::int64_t block) const
  {
    return this->Ranges[static_cast<std::size_t>(block)];
  }

  /// The blocks that are active for at least one of the isovalues, ascending.
  std::vector<std::int64_t> FindActiveBlocks(const std::vector<double>& isovalues) const;

  /// The blocks that are entirely inside for at least one of the isovalues, ascending.
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
