// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreSpectra_h
#define isosurface_StoreSpectra_h

#include "Base/Communicator.h"
#include "Partition/BlockWorkload.h"
#include "Partition/WorkloadSpectrum.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace isosurface
{

/**
 * The workload spectra of the stores while these are written: each rank has those of its own stores
 * (d mod P == r), which several threads add to. Gather() brings them to rank 0.
 */
class StoreSpectra
{
public:
  /// bins[array].
  StoreSpectra(
    std::vector<SpectrumBins> bins, std::uint32_t stores, std::size_t rank, std::size_t ranks);

  const std::vector<SpectrumBins>& GetBins() const { return this->Bins; }

  /// Adds what was counted in a block of one of this rank's stores.
  void Add(std::uint32_t store, std::size_t array, BlockWorkload& counted);

  /// The counts of this rank's stores: to be sent to rank 0.
  Message Pack() const;
  /// The spectra of all stores, from all ranks' messages: result[array][store].
  std::vector<std::vector<WorkloadSpectrum>> Unpack(const std::vector<Message>& messages) const;

  /// The memory of this rank's spectra; on rank 0 also that of writing all of them.
  static std::uint64_t GetBytes(const std::vector<SpectrumBins>& bins, std::uint32_t stores,
    std::size_t rank, std::size_t ranks);

private:
  struct Spectra
  {
    std::vector<WorkloadSpectrum> Arrays;
    std::mutex Mutex;
  };

  std::vector<SpectrumBins> Bins;
  std::uint32_t Stores;
  std::size_t Rank;
  std::size_t Ranks;
  std::vector<std::unique_ptr<Spectra>> Mine; ///< of the stores Rank, Rank + Ranks, ...
};

} // namespace isosurface

#endif
