// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeSpectra_h
#define isosurface_VolumeSpectra_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/GridPlace.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/SpectraFile.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * The spectra of one time step: of the whole volume, and of each store, which add up to the whole.
 * They are in a file of their own, `spectra` in the time step's folder, so that the header stays
 * small with many stores and time steps.
 */
class VolumeSpectra
{
public:
  using Spectrum = std::shared_ptr<const WorkloadSpectrum>;

  /// The file of a time step.
  static std::string GetPath(
    FileSystem& files, const std::string& volumePath, const std::string& generation);

  /// What the file has in its header: it belongs to these stores, whose checksums are known.
  static std::uint64_t GetIdentity(const TimeStepDescription& step);

  /// Reads the spectra of the whole volume from a time step's folder. `scale`: from the grid in the file
  /// to that of the volume; an area that it does not tell becomes unknown.
  static Result<std::shared_ptr<const VolumeSpectra>> Read(FileSystem& files,
    const std::string& volumePath, const TimeStepDescription& step, std::size_t variables,
    const GridScale& scale = {});

  const Spectrum& GetTotal(std::size_t variable) const { return this->Totals[variable]; }
  /// Reads the spectrum of a store.
  Result<Spectrum> GetStore(std::size_t variable, std::size_t store) const;

private:
  Spectrum Share(WorkloadSpectrum&& spectrum) const;

  std::unique_ptr<SpectraFile> File;
  GridScale Scale;
  std::vector<Spectrum> Totals; ///< per variable
};

} // namespace isosurface

#endif
