// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockCounts_h
#define isosurface_BlockCounts_h

#include "Ground/Base/Communicator.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/SampleView.h"
#include "Ground/Volume/ValueKey.h"
#include "Storage/Record/DecodedBlock.h"
#include "Storage/Spectrum/GrowingSpectrum.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/SpectraFile.h"
#include "Storage/Writing/BlockExchange.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace isosurface
{

/// The spectra of the stores while these are written. Each rank has those of its own stores
/// (d mod P == r), which several threads add to, and packs them when the store is finished. Then
/// rank 0 gets the packed spectra, and all ranks those of the whole volume.
class StoreSpectra
{
public:
  /// The grid's lines must outlive this object.
  StoreSpectra(const MeasuredGrid& grid, ArrayVariables variables, std::uint32_t stores,
    std::size_t rank, std::size_t ranks);

  const MeasuredGrid& GetGrid() const { return this->Grid; }

  /// Adds the counts of a block of one of this rank's stores.
  void Add(std::uint32_t store, std::size_t variable, const EdgeSums& counted);

  /// The counts so far of one of this rank's stores, as bytes, and back: false if the bytes are of
  /// other variables.
  std::vector<std::uint8_t> PackSums(std::uint32_t store) const;
  bool UnpackSums(std::uint32_t store, const std::vector<std::uint8_t>& packed);

  /// When all blocks are added: ranges[variable] is that of the finite values of all stores, which
  /// decides the bins.
  void SetRanges(const std::vector<KeyRange>& ranges);

  /// Adds a store's active blocks and packs its spectra. `entries`: those of its blocks;
  /// ranges[variable][block]: the value ranges of all blocks of the volume. Threads may finish
  /// several stores at once. False if what was counted is beyond the ranges.
  bool FinishStore(std::uint32_t store, const std::vector<BlockDirectoryEntry>& entries,
    const std::vector<std::vector<KeyRange>>& ranges);

  /// When all stores are finished: the sum of those of this rank, per variable.
  const std::vector<WorkloadSpectrum>& GetTotals() const { return this->Totals; }
  /// Makes the totals of one rank those of the whole volume. Collective.
  static void ReduceTotals(Communicator& communicator, std::vector<WorkloadSpectrum>& totals);

  /// The packed spectra of this rank's stores: to be sent to rank 0.
  Message Pack() const;
  /// The packed spectra of all stores, from all ranks' messages, for SpectraFile::Write.
  std::vector<SpectraFile::Section> Unpack(const std::vector<Message>& messages) const;

  /// The memory of this rank's spectra; on rank 0 also that of writing all of them.
  std::uint64_t GetBytes() const;
  /// The memory of a thread's counters, for blocks of `blockSize` cells a side.
  static std::uint64_t GetCounterBytes(std::uint64_t blockSize);

private:
  struct Store
  {
    std::vector<GrowingSpectrum> Sums; ///< per variable, until the store is finished
    std::vector<SpectraFile::Section> Packed;
    std::mutex Mutex;
  };

  WorkloadSpectrum MakeSpectrum(std::size_t variable) const;

  MeasuredGrid Grid;
  ArrayVariables Variables;
  std::vector<KeyRange> FiniteRanges; ///< per variable
  std::uint32_t Stores;
  std::size_t Rank;
  std::size_t Ranks;
  std::vector<std::unique_ptr<Store>> Mine; ///< the stores Rank, Rank + Ranks, ...
  std::vector<WorkloadSpectrum> Totals;     ///< per variable: of this rank's finished stores
  std::mutex TotalsMutex;
};

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
