// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SourceFiles_h
#define isosurface_SourceFiles_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

#include <string>
#include <vector>

namespace isosurface
{

/// Files that samples are read from, and their state when that began.
struct SourceFiles
{
  std::vector<std::string> Paths; ///< OpenedVolume::Files
  FileState State;

  static Result<SourceFiles> Find(FileSystem& files, std::vector<std::string> paths);
};

} // namespace isosurface

#endif
