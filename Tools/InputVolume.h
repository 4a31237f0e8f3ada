// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_InputVolume_h
#define isosurface_InputVolume_h

#include "BlockVolumeOptions.h"

#include "Ground/Base/Status.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/GridGeometry.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/SourceRecord.h"

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

/**
 * Opens a file with VTK's reader for its file extension. A folder or pattern of PNG, JPEG or BMP files is
 * a stack of slices, the first row of each at y 0 (as of TIFF); the files of any other pattern are time
 * steps, of which `step` is opened. A volume of at most `wholeBytes` is read
 * at once, because many readers always read their whole file. Of a larger one, boxes of its extent
 * are read; the reader may read more than that. Errors name the file, with VTK's message.
 */
Result<InputVolume> OpenPipelineInput(const std::string& path, std::size_t step,
  const std::vector<std::string>& arrays, bool withCells, std::uint64_t wholeBytes);

} // namespace isosurface

#endif
