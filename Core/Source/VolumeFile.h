// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeFile_h
#define isosurface_VolumeFile_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Source/SlabSource.h"
#include "Volume/GridGeometry.h"
#include "Volume/ValueType.h"

#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * A volume in files, opened by its name, whose samples are read part by part:
 *
 *     .mhd .mha      MetaImage (MetaImageHeader.h)
 *     .nrrd .nhdr    NRRD (NrrdHeader.h)
 *     .tif .tiff     TIFF, a slice a page (TiffFile.h)
 *     a folder       a TIFF stack: all files in it that end in .tif or .tiff
 *     *, ? in a name a TIFF stack: all files of the folder that fit the pattern
 *
 * The files of a stack are taken in the order of the numbers in their names ("slice9.tif" before
 * "slice10.tif"); where one number alone tells them apart, it must go up by equal steps, so that a
 * slice that is missing is seen.
 */
struct VolumeFile
{
  GridGeometry Grid;
  std::string ArrayName;
  ValueType Type = ValueType::UInt8;
  std::unique_ptr<SlabSource> Source;

  /// Whether Open() knows what to do with the name. Looks at folders, not into files.
  static bool IsKnown(FileSystem& files, const std::string& path);

  /// Unsupported for names that are not known. `files` must outlive the source. Cost: the headers;
  /// of a TIFF stack those of all pages.
  static Result<VolumeFile> Open(FileSystem& files, const std::string& path);

  /// The files of a stack in their order; also of a single one. NotFound if there are none, Corrupt
  /// if one is missing.
  static Result<std::vector<std::string>> FindStack(FileSystem& files, const std::string& path);
};

} // namespace isosurface

#endif
