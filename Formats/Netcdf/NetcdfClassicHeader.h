// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NetcdfClassicHeader_h
#define isosurface_NetcdfClassicHeader_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

#include <string>

namespace isosurface
{

/**
 * Checks that a file of the classic formats of NetCDF (versions 1, 2 and 5) has all samples of a
 * variable: the library reads zeros where a truncated file has none. Without a variable, that its header is
 * complete. Ok for other files. Errors:
 * Corrupt, which names the file and the variable.
 *
 * Source: "NetCDF Classic Format Specification", Unidata; its grammar of the header.
 */
Status CheckNetcdfClassicSize(
  FileSystem& files, const std::string& path, const std::string& variable);

} // namespace isosurface

#endif
