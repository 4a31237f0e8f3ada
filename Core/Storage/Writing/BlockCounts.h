// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockCounts_h
#define isosurface_BlockCounts_h

#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/SampleView.h"
#include "Ground/Volume/ValueKey.h"
#include "Storage/Record/DecodedBlock.h"
#include "Storage/Spectrum/GrowingSpectrum.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Writing/BlockExchange.h"
#include "Storage/Writing/StoreSpectra.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace isosurface
{

/// What a rank counts in the blocks that it writes: their value ranges, which the trees index, the
/// range of all finite values, and the spectra of its stores.
class BlockCounts
{
public:
  /// `header`: of the grid that is written; must outlive this object. `threads`: how many add
  /// blocks.
  BlockCounts(const BlockedVolumeHeader& header, std::size_t rank, std::size_t ranks, int threads);

  /// Adds a filled block. `views`: the samples of its first variables, where its record has them in
  /// several levels; others are assembled from that. Each thread has its own number; a block is added
  /// once.
  void Add(const PendingBlock& block, const std::vector<SampleView>& views, int thread);
  /// Adds the finite values of blocks that another run counted, per variable.
  void AddFiniteRanges(const std::vector<KeyRange>& ranges);

  /// Per variable and block; empty for blocks that this rank does not write.
  const std::vector<std::vector<KeyRange>>& GetRanges() const { return this->Ranges; }
  std::vector<std::vector<KeyRange>>& GetRanges() { return this->Ranges; }
  /// Those of the finite values of all blocks so far, per variable.
  std::vector<KeyRange> JoinFiniteRanges() const;

  StoreSpectra& GetSpectra() { return this->Spectra; }
  const StoreSpectra& GetSpectra() const { return this->Spectra; }

private:
  /// What a thread counts.
  struct Counters
  {
    BlockSpectrum Spectrum;             ///< of one variable after the other
    std::vector<KeyRange> FiniteRanges; ///< per variable, of all blocks
  };

  void AddVariable(
    const PendingBlock& block, std::size_t variable, const SampleView& samples, Counters& counters);
  /// The samples of a stored variable in the record of a block, if these are all in one place there.
  std::optional<SampleView> ViewRecord(const PendingBlock& block, std::size_t variable) const;
  std::shared_ptr<DecodedBlock> AssembleVariable(
    const PendingBlock& block, std::size_t variable) const;

  BlockGrid Grid;
  ArrayVariables Variables;
  StoreSpectra Spectra;
  std::vector<std::vector<KeyRange>> Ranges; ///< per variable and block
  std::vector<Counters> Threads;
};

} // namespace isosurface

#endif
