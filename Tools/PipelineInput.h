// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PipelineInput_h
#define isosurface_PipelineInput_h

#include "InputVolume.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

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
