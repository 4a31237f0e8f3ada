// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PipelineFiles_h
#define isosurface_PipelineFiles_h

#include "Ground/Base/Status.h"

#include <cstddef>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * The files of an input that VTK reads: the file itself; the slices of a folder or pattern (SliceFiles);
 * or, of the files of any other pattern, which are time steps, the one of number `step`.
 */
struct PipelineFiles
{
  std::vector<std::string> Paths;
  std::size_t Steps = 1;
  std::string LeftOut; ///< says what was passed over; empty if nothing was

  /// Errors: those of SliceFiles::Find(); InvalidArgument if there is no such step.
  static Result<PipelineFiles> Find(const std::string& input, std::size_t step);
};

} // namespace isosurface

#endif
