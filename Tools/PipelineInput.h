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
 * Opens a file with that reader of VTK's that its name asks for. What takes no more than
 * `wholeBytes` is read at once, since many readers go through all of a file for any part of it;
 * else the reader is asked for parts of its extent, and whether it reads no more than these is its
 * own affair. Errors name the file, and give what VTK said.
 */
Result<InputVolume> OpenPipelineInput(
  const std::string& path, const std::vector<std::string>& arrays, std::uint64_t wholeBytes);

} // namespace isosurface

#endif
