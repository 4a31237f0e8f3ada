// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ProcessUse_h
#define isosurface_ProcessUse_h

#include <cstddef>
#include <string>

namespace isosurface
{

/// What this process uses now, as /proc tells.
struct ProcessUse
{
  std::size_t Files = 0; ///< open below a folder
  std::size_t Threads = 0;
  std::size_t Mebibytes = 0; ///< resident
};

ProcessUse MeasureUse(const std::string& folder);

} // namespace isosurface

#endif
