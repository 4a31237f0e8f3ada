// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeWriting_h
#define isosurface_VolumeWriting_h

#include "ArrayLikeSource.h"
#include "VolumeFile.h"

#include "Storage/Writing/BlockedVolumeWriter.h"

#include <functional>
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
  /// Python raises, and errors. Warns of a disk that has no room for it, as WriteFile() does.
  void WriteArrays(const std::vector<std::string>& names, const std::vector<ArrayLike>& arrays,
    const std::optional<Index3>& chunk) const;
  /// Writes a time step of a file. The GIL is held, and released meanwhile.
  void WriteFile(VolumeFile& file, std::size_t timeStep) const;

private:
  /// Writes what open() gives a pointer to. The GIL is held, and released meanwhile; rethrow() is called
  /// with it afterwards, and may throw what the source has raised.
  template <typename OpenT>
  void Write(const std::vector<ArrayDescription>& arrays, const OpenT& open,
    const std::function<void()>& rethrow) const;
};

} // namespace isosurface

#endif
