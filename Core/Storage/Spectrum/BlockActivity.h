// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockActivity_h
#define isosurface_BlockActivity_h

#include "Ground/Volume/ValueKey.h"
#include "Ground/Volume/ValueType.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Counts active blocks and their bytes for all isovalues of a spectrum at once. A block is active
 * at a bin if minimum < t <= maximum, where t is the threshold of the bin's edge. Exact. Cost: two
 * binary searches a block.
 */
class BlockActivity
{
public:
  /// `bins` are chosen for values of the type (SpectrumBins::Choose).
  BlockActivity(ValueType type, const SpectrumBins& bins);

  /// Adds a block of this value range. A query reads `bytes` bytes of it.
  void Add(const KeyRange& range, std::uint64_t bytes);

  /// Sets ActiveBlocks and Bytes of a spectrum that has the bins of this object.
  void SetActivity(WorkloadSpectrum& spectrum) const;

private:
  std::vector<ValueKey> Thresholds; ///< per bin, ascending
  // For each bin, and for one after the last: the difference to the bin before, modulo 2^64.
  std::vector<std::uint64_t> Blocks;
  std::vector<std::uint64_t> Bytes;
};

} // namespace isosurface

#endif
