// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreSpectra_h
#define isosurface_StoreSpectra_h

#include "Ground/Base/Communicator.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/ValueKey.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/SpectraFile.h"
#include "Surface/Spectrum/BlockMeasure.h"
#include "Surface/Spectrum/BlockWorkload.h"
#include "Surface/Spectrum/WorkloadSpectrum.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace isosurface
{

/// Counts one variable in the blocks that one thread finishes.
struct BlockCounters
{
  BlockCounters(const SpectrumBins& bins, const MeasuredGrid& grid)
    : Workload(bins)
    , Measure(bins, grid)
  {
  }
  void Count(const SampleView& samples)
  {
    this->Workload.Count(samples);
    this->Measure.Count(samples);
  }
  BlockWorkload Workload;
  BlockMeasure Measure;
};

/// The spectra of the stores while these are written. Each rank has those of its own stores
/// (d mod P == r), which several threads add to, and packs them when the store is finished. Then
/// rank 0 gets the packed spectra, and all ranks those of the whole volume.
class StoreSpectra
{
public:
  /// bins[variable]. The grid's lines must outlive this object.
  StoreSpectra(const MeasuredGrid& grid, ArrayVariables variables, std::vector<SpectrumBins> bins,
    std::uint32_t stores, std::size_t rank, std::size_t ranks);

  /// Counters of all variables, for one thread.
  std::vector<BlockCounters> MakeCounters() const;

  /// Adds what was counted in blocks of one of this rank's stores, and resets the counters.
  void Add(std::uint32_t store, std::size_t variable, BlockCounters& counted);

  /// Adds a store's active blocks and packs its spectra. `entries`: those of its blocks;
  /// ranges[variable][block]: the value ranges of all blocks of the volume. Threads may finish
  /// several stores at once.
  void FinishStore(std::uint32_t store, const std::vector<BlockDirectoryEntry>& entries,
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
  /// The memory of a thread's counters, for blocks of so many cells a side.
  static std::uint64_t GetCounterBytes(std::size_t variables, std::uint64_t blockSize);

private:
  struct Sums
  {
    WorkloadSpectrum Spectrum; ///< triangles and cells, until the store is finished
    MeasureSums Measure;
    SpectraFile::Section Packed;
  };
  struct Store
  {
    std::vector<Sums> Arrays;
    std::mutex Mutex;
  };

  WorkloadSpectrum MakeSpectrum(std::size_t variable) const;

  MeasuredGrid Grid;
  ArrayVariables Variables;
  std::vector<SpectrumBins> Bins;
  std::uint32_t Stores;
  std::size_t Rank;
  std::size_t Ranks;
  std::vector<std::unique_ptr<Store>> Mine; ///< the stores Rank, Rank + Ranks, ...
  std::vector<WorkloadSpectrum> Totals;     ///< per variable: of this rank's finished stores
  std::mutex TotalsMutex;
};

} // namespace isosurface

#endif
