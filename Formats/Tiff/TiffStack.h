// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffStack_h
#define isosurface_TiffStack_h

#include "Formats/Source/FileNames.h"
#include "Formats/Source/FormatFunctions.h"

#include <string>
#include <vector>

namespace isosurface
{

/**
 * A volume of TIFF: a file with a slice a page, a folder of files, or a name with * or ?, which stand
 * for characters. The files are sorted by the numbers in their names ("slice9.tif" before
 * "slice10.tif"). If they differ in one number only, it must increase by equal steps: otherwise a
 * slice is missing.
 */
extern "C" const FormatFunctions IsosurfaceTiffFormat;

/// The files of a stack in their order, or the file itself. NotFound if there are none, Corrupt if
/// one is missing.
Result<std::vector<std::string>> FindTiffStack(FileSystem& files, const std::string& path);

inline bool IsTiffName(const std::string& path)
{
  const std::string extension = FindExtension(path);
  return extension == ".tif" || extension == ".tiff";
}

} // namespace isosurface

#endif
