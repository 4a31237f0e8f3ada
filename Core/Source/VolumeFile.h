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
 * A volume in files, opened by name:
 *
 *     .mhd .mha      MetaImage (MetaImageHeader.h)
 *     .nrrd .nhdr    NRRD (NrrdHeader.h)
 *     .tif .tiff     TIFF, a slice on each page (TiffFile.h)
 *     a folder       a TIFF stack: all files in the folder that end in .tif or .tiff
 *     *, ? in a name a TIFF stack: all files of the folder that match the pattern
 *
 * The files of a stack are sorted by the numbers in their names ("slice9.tif" before
 * "slice10.tif"). If they differ in one number only, it must increase by equal steps: otherwise a
 * slice is missing.
 */
struct VolumeFile
{
  GridGeometry Grid;
  std::string ArrayName;
  ValueType Type = ValueType::UInt8;
  std::unique_ptr<SlabSource> Source;

  /// Whether Open() supports the name. Looks at folders, but does not open files.
  static bool IsKnown(FileSystem& files, const std::string& path);

  /// Opens a volume. Unsupported if not IsKnown(). `files` must outlive the source. Cost: reading
  /// the headers; for a TIFF stack, the directories of all pages.
  static Result<VolumeFile> Open(FileSystem& files, const std::string& path);

  /// The files of a stack in their order, or the file itself. NotFound if there are none, Corrupt
  /// if one is missing.
  static Result<std::vector<std::string>> FindStack(FileSystem& files, const std::string& path);
};

} // namespace isosurface

#endif
