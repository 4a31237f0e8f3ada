// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MemorySpectrum_h
#define isosurface_MemorySpectrum_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"
#include "Surface/Pieces/MemoryGrids.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace isosurface
{

/// The contour spectra of grids in memory. Any thread may count them.
class MemorySpectrum
{
public:
  /// `component`: as FindChosenComponent takes it.
  MemorySpectrum(MemoryGrids samples, int component, int threads)
    : Samples(std::move(samples))
    , Component(component)
    , Threads(threads)
  {
  }

  /// What tells these samples, and the choice of them, from others on this rank.
  std::uint64_t ComputeFingerprint() const;
  /// On this rank.
  std::uint64_t CountSamples() const { return this->Samples.CountSamples(); }

  /// Collective. Errors of one rank are errors of all: InvalidArgument, Aborted, OutOfMemory. Cost: two
  /// passes over the samples, and one for a magnitude.
  Status Count(Communicator& ranks, const Progress& progress);
  /// An isovalue to begin with (ProposeIsovalue), of at most some two million of the samples: which ones,
  /// does not depend on ranks and pieces. NaN if there is none. Collective. Errors: OutOfMemory.
  Result<double> Propose(Communicator& ranks) const;
  /// One for each grid, in equal bins; the same on all ranks.
  const std::vector<WorkloadSpectrum>& GetSpectra() const { return this->Spectra; }

private:
  const MemoryGrids Samples;
  const int Component;
  const int Threads;
  std::vector<WorkloadSpectrum> Spectra;
};

} // namespace isosurface

#endif
