// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PipelineInput_h
#define isosurface_PipelineInput_h

#include "InputVolume.h"

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * Opens a file with VTK's reader for its file extension. A volume of at most `wholeBytes` is read
 * at once, because many readers always read their whole file. Of a larger one, boxes of its extent
 * are read; the reader may read more than that. Errors name the file, with VTK's message.
 */
Result<InputVolume> OpenPipelineInput(const std::string& path,
  const std::vector<std::string>& arrays, bool withCells, std::uint64_t wholeBytes);

} // namespace isosurface

#endif
