// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffStack_h
#define isosurface_TiffStack_h

#include "Formats/Source/FileNames.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

#include <string>
#include <vector>

namespace isosurface
{

/**
 * The files of a stack in their order: a file itself, those in a folder, or of a name with * or ?, which
 * stand for characters. They are sorted by the numbers in their names ("slice9.tif" before
 * "slice10.tif"). If they differ in one number only, it must increase by equal steps: otherwise a slice
 * is missing. NotFound if there are none, Corrupt if one is missing.
 */
Result<std::vector<std::string>> FindTiffStack(FileSystem& files, const std::string& path);

inline bool IsTiffName(const std::string& path)
{
  const std::string extension = FindExtension(path);
  return extension == ".tif" || extension == ".tiff";
}

} // namespace isosurface

#endif
