// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MemorySpectrum_h
#define isosurface_MemorySpectrum_h

#include "Ground/Base/CollectiveTask.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ranks/Query/Field.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"
#include "Surface/Pieces/MemoryGrids.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// The contour spectra of grids in memory, a field of two levels: at level 0 they are counted, and at
/// level 1, which is that of many samples first, not yet.
class MemorySpectrum : public Field
{
public:
  /// Begins an execution. `component`: as FindChosenComponent takes it. `samplesAtOnce`: the number of
  /// samples of all ranks that may be counted at once.
  void Ask(MemoryGrids samples, int component, int threads, std::uint64_t samplesAtOnce);
  /// Level 0: counts them, unless they are those that were counted before. Collective. Errors of one rank are
  /// errors of all: InvalidArgument, Aborted, OutOfMemory. Cost: two passes over the samples, and one for a
  /// magnitude.
  Status Count(Communicator& ranks, const Progress& progress);
  /// One for each grid, in equal bins; the same on all ranks.
  const std::vector<WorkloadSpectrum>& GetSpectra() const { return this->Spectra; }
  /// An isovalue to begin with (ProposeIsovalue), of at most some two million of the samples: which ones,
  /// does not depend on ranks and pieces. NaN if there is none. Collective. Errors: OutOfMemory.
  Result<double> Propose(Communicator& ranks);

  std::string GetName() const override { return "the images of the input"; }
  bool IsSame() const override { return this->Same; }
  int FindFinestLevel(int) const override { return 0; }
  std::vector<std::uint64_t> CountForFirst() const override
  {
    return { this->AreCounted ? 0 : this->Samples.CountSamples() };
  }
  Result<First> FindFirst(
    Communicator&, const std::vector<std::uint64_t>& sums, int finest) override
  {
    return First{ sums[0] > this->SamplesAtOnce ? 1 : finest, true, true };
  }
  Status Prepare(Communicator& ranks, int) override;
  CollectiveTask* GetPrepared() override { return this->Work.get(); }
  void DropPrepared() override { this->Work.reset(); }

private:
  Status CountSamples(Communicator& ranks, const Progress& progress);

  MemoryGrids Samples; ///< none once they are used
  int Component = 0;
  int Threads = 1;
  std::uint64_t SamplesAtOnce = 0;
  std::uint64_t Identity = 0; ///< of the samples and the component
  bool Same = false;
  bool AreCounted = false;
  std::vector<WorkloadSpectrum> Spectra;
  std::unique_ptr<CollectiveTask> Work; ///< the last member: it uses the others
};

} // namespace isosurface

#endif
