// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImageSpectrum_h
#define isosurface_ImageSpectrum_h

#include "ContouredArray.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "ImagePieces.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// The contour spectra of images in memory that the ranks have pieces of. Collect() is for the thread of
/// the pipeline, Count() for any thread: meanwhile this object keeps the images' arrays.
class ImageSpectrum
{
public:
  /// Finds the array in the input, on all ranks. Collective. Errors: CollectContouredPieces.
  Status Collect(Communicator& ranks, vtkInformation* input, const ArrayChooser& choose,
    const std::string& name, int component, int threads);

  /// What tells these samples, and the choice of them, from others on this rank.
  std::uint64_t ComputeFingerprint() const;
  /// On this rank.
  std::uint64_t CountSamples() const;

  /// Collective. Errors of one rank are errors of all: InvalidArgument, Aborted, OutOfMemory. Cost: two
  /// passes over the samples, and one for a magnitude.
  Status Count(Communicator& ranks, const Progress& progress);
  /// An isovalue to begin with (ProposeIsovalue), of at most some two million of the samples: which ones,
  /// does not depend on ranks and pieces. NaN if there is none. Collective. Errors: OutOfMemory.
  Result<double> Propose(Communicator& ranks) const;
  /// One for each grid, in equal bins; the same on all ranks.
  const std::vector<WorkloadSpectrum>& GetSpectra() const { return this->Spectra; }

private:
  CellAverages Averages;
  ImagePieces Pieces;
  int Component = 0;
  int Threads = 1;
  std::vector<WorkloadSpectrum> Spectra;
};

} // namespace isosurface

#endif
