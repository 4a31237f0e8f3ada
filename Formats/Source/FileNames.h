// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FileNames_h
#define isosurface_FileNames_h

#include "Ground/Base/FileSystem.h"

#include <string>
#include <vector>

namespace isosurface
{

/// The extension of a file or folder in lower case, ".gz" together with the one before it.
std::string FindExtension(const std::string& path);
/// Whether the last part of the path has * or ?, which stand for characters.
bool IsNamePattern(const std::string& path);
/// The names in a folder; none if the path is no folder.
std::vector<std::string> ListNames(FileSystem& files, const std::string& folder);

} // namespace isosurface

#endif
