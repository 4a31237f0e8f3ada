// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockActivity_h
#define isosurface_BlockActivity_h

#include "Partition/WorkloadSpectrum.h"
#include "Volume/ValueKey.h"
#include "Volume/ValueType.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Counts blocks that are active, and their bytes, for all isovalues at once: exactly those with
 * minimum < t <= maximum at the threshold t of each bin's edge. Cost: two binary searches a block.
 */
class BlockActivity
{
public:
  /// `bins` are chosen for values of the type (SpectrumBins::Choose).
  BlockActivity(ValueType type, const SpectrumBins& bins);

  /// Adds a block of this range of values, of which a query reads so many bytes.
  void Add(const KeyRange& range, std::uint64_t bytes);

  /// Sets the spectrum's ActiveBlocks and Bytes, for the bins that this is for.
  void SetActivity(WorkloadSpectrum& spectrum) const;

private:
  std::vector<ValueKey> Thresholds; ///< per bin, ascending
  // Per bin and one behind: how the sums differ from the bin before, modulo 2^64.
  std::vector<std::uint64_t> Blocks;
  std::vector<std::uint64_t> Bytes;
};

} // namespace isosurface

#endif
