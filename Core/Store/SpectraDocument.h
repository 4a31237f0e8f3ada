// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SpectraDocument_h
#define isosurface_SpectraDocument_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Partition/WorkloadSpectrum.h"

#include <cstddef>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * Reads `spectra.json`, what volumes had before they had a file `spectra`: triangles and active
 * cells of each store. Nothing writes it any more.
 *
 *   { "format": "ScalableIsosurface spectra", "formatVersion": 1,
 *     "arrays": [ { "first": integer, "exponent": integer, "count": n,             per array
 *                   "stores": [ { "triangles": [n integers], "activeCells": [n integers] },
 *                               ... ] }, ... ],
 *     "checksum": as in the header }
 *
 * Entry b counts at the isovalue (first + b) * 2^exponent (SpectrumBins).
 */
struct SpectraDocument
{
  std::vector<WorkloadSpectrum> Totals;              ///< per array
  std::vector<std::vector<WorkloadSpectrum>> Stores; ///< per array and store

  static Result<SpectraDocument> Read(
    FileSystem& files, const std::string& path, std::size_t arrays, std::size_t stores);
};

} // namespace isosurface

#endif
