// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeWriting_h
#define isosurface_VolumeWriting_h

#include "ArrayLikeSource.h"
#include "Formats/Files/VolumeFile.h"

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

  /// Writes objects of Python, the same arrays at each of the times. The GIL is held; it is released between their slices. Throws what
  /// Python raises, and errors. Warns of a disk that has no room for it, as WriteFile() does.
  void WriteArrays(const std::vector<ArrayDescription>& descriptions,
    const std::vector<std::vector<ArrayLike>>& steps,
    const std::vector<std::optional<double>>& times, const std::optional<Index3>& chunk) const;
  /// Writes the time steps of a file, of such times. All become visible with the last one, so that an
  /// error of any leaves an older volume. The GIL is held, and released meanwhile.
  void WriteFile(VolumeFile& file, const std::vector<std::optional<double>>& times) const;

private:
  /// Calls writeStep(writer, settings, step) for each time. All become visible with the last one.
  template <typename StepT>
  void WriteSteps(const std::vector<std::optional<double>>& times, const StepT& writeStep) const;
  /// Writes a time step of what open(settings) gives a pointer to. The GIL is held, and released meanwhile;
  /// rethrow() is called with it afterwards, and may throw what the source has raised.
  template <typename OpenT>
  void WriteStep(BlockedVolumeWriter& writer, BlockedVolumeSettings settings,
    const std::vector<ArrayDescription>& arrays, const OpenT& open,
    const std::function<void()>& rethrow) const;
};

} // namespace isosurface

#endif
