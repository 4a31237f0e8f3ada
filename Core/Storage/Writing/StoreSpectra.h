// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreSpectra_h
#define isosurface_StoreSpectra_h

#include "Ground/Base/Communicator.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/ValueKey.h"
#include "Storage/Spectrum/GrowingSpectrum.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/SpectraFile.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
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

} // namespace isosurface

#endif
