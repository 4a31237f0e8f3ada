// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_InputVolume_h
#define isosurface_InputVolume_h

#include "BlockVolumeOptions.h"

#include "Ground/Base/Status.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/GridGeometry.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/SourceFiles.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// The volume to write, as a whole on any rank.
struct InputVolume
{
  GridGeometry Grid;
  std::optional<GridLines> Lines; ///< of a rectilinear grid
  std::vector<ArrayDescription> Arrays;
  std::optional<double> Time;
  std::vector<double> Times;   ///< of all time steps that the input has; may be empty
  std::string LeftOut;         ///< says what cannot be written; empty if everything can
  std::uint64_t HeldBytes = 0; ///< of samples in memory
  SourceFiles Files;           ///< that the samples are read from
  std::shared_ptr<void> Owner; ///< of what the source reads from; destroyed after it
  std::unique_ptr<BoxSource> Source;

  /// Opens what the options name: samples without a header, a format that Core reads part by part,
  /// or one of VTK's. `step`: of the time steps of the input.
  static Result<InputVolume> Open(const BlockVolumeOptions& options, std::size_t step);
};

/// The arrays of a file with these names, in this order; all if there are no names. Error: NotFound,
/// with the names that the file has.
Result<std::vector<ArrayDescription>> ChooseArrays(const std::string& path,
  const std::vector<ArrayDescription>& arrays, const std::vector<std::string>& names);

} // namespace isosurface

#endif
