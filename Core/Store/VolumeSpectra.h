// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeSpectra_h
#define isosurface_VolumeSpectra_h

#include "Base/Communicator.h"
#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Partition/WorkloadSpectrum.h"
#include "Store/BlockedVolumeHeader.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * The workload spectra of one time step: of each store, and of the whole, which is their sum. They
 * stand in a file of their own in the time step's folder, `spectra.json`, so that the header stays
 * small with many stores and time steps:
 *
 *   { "format": "ScalableIsosurface spectra", "formatVersion": 1,
 *     "arrays": [ { "first": integer, "exponent": integer, "count": n,          per variable
 *                   "stores": [ { "triangles": [n integers], "activeCells": [n integers] },
 *                               ... ] }, ... ],
 *     "checksum": as in the header }
 *
 * Entry b counts at the isovalue (first + b) * 2^exponent (SpectrumBins).
 */
struct VolumeSpectra
{
  /// Per variable: the whole volume's.
  std::vector<std::shared_ptr<const WorkloadSpectrum>> Totals;
  /// Per variable and store.
  std::vector<std::vector<std::shared_ptr<const WorkloadSpectrum>>> Stores;

  /// The file of a time step.
  static std::string GetPath(const std::string& volumePath, const std::string& generation);

  /// stores[variable][store]; all spectra of a variable have the same bins.
  static Status Write(FileSystem& files, const std::string& path,
    const std::vector<std::vector<WorkloadSpectrum>>& stores);

  /// A spectrum's counts on their way between ranks: triangles, then active cells, each a run of
  /// 64-bit numbers. The receiver knows the bins; `position` moves on to the next spectrum.
  static void AppendCounts(const WorkloadSpectrum& spectrum, Message& message);
  static void TakeCounts(const Message& message, std::size_t& position, WorkloadSpectrum& spectrum);

  static Result<std::shared_ptr<const VolumeSpectra>> Read(
    FileSystem& files, const std::string& path, std::size_t variables, std::size_t stores);
};

} // namespace isosurface

#endif
