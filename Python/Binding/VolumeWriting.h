// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeWriting_h
#define isosurface_VolumeWriting_h

#include "ArrayLikeSource.h"
#include "VolumeFile.h"

#include "Storage/Writing/BlockedVolumeWriter.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// A blocked volume to be written.
struct VolumeWriting
{
  std::string Path;
  GridGeometry Grid; ///< Extent is that of the samples
  BlockedVolumeSettings Settings;

  /// Writes objects of Python. The GIL is held; it is released between their slices. Throws what
  /// Python raises, and errors.
  void WriteArrays(const std::vector<std::string>& names, const std::vector<ArrayLike>& arrays,
    const std::optional<Index3>& chunk) const;
  /// Writes a time step of a file. The GIL is held, and released meanwhile.
  void WriteFile(VolumeFile& file, std::size_t timeStep) const;

private:
  Status Write(
    const std::vector<ArrayDescription>& arrays, BoxSource& source, const Progress& progress) const;
};

} // namespace isosurface

#endif
