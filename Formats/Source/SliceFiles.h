// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SliceFiles_h
#define isosurface_SliceFiles_h

#include "Ground/Base/FileSystem.h"

#include <string>
#include <vector>

namespace isosurface
{

/**
 * The images in a folder, or of a pattern, that are the slices of one volume: those of the kind that most
 * of them have. Hidden files, files of other kinds and copies ("a (1).tif" of the same bytes as "a.tif")
 * are passed over. If the names differ in one number only, it must increase by equal steps: otherwise a
 * slice is missing. The path of a file stands for itself.
 */
struct SliceFiles
{
  std::string Kind;               ///< "TIFF", "PNG", "JPEG" or "BMP"
  std::vector<std::string> Paths; ///< in the order of the numbers in their names
  std::string LeftOut;            ///< says what was passed over; empty if nothing was

  /// Errors: NotFound if there are none; Corrupt if one is missing, or a copy differs.
  static Result<SliceFiles> Find(FileSystem& files, const std::string& path);
  /// The kind that most of the names have, by their extensions. Empty: they are no images.
  static std::string FindKind(const std::vector<std::string>& names);
};

} // namespace isosurface

#endif
