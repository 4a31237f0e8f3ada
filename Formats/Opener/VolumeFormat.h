// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeFormat_h
#define isosurface_VolumeFormat_h

#include "Formats/Source/FolderFiles.h"
#include "Formats/Source/FormatFunctions.h"

#include <string>
#include <string_view>
#include <vector>

namespace isosurface
{

/// A format of volumes: how its files are recognised, and what reads them.
struct VolumeFormat
{
  /// Bytes at a place of the first 512 of a file.
  struct Mark
  {
    std::string_view Text;
    std::size_t Offset = 0;
  };

  std::string_view Name;                    ///< for messages
  std::vector<std::string_view> Extensions; ///< in lower case
  std::vector<Mark> Marks;                  ///< any of them tells the format
  /// Whether a folder, of which `names` are the files, is a volume. Null: no folder is.
  bool (*IsFolder)(
    FileSystem& files, const std::string& path, const std::vector<std::string>& names) = nullptr;
  FormatFunctions Functions;    ///< if this library has them
  const char* Module = nullptr; ///< which has them otherwise (LoadFormatModule)
  bool TakesAxes = false;       ///< whether VolumeChoice::Axes may say what the axes are
  bool IsLocal = false; ///< whether a library opens the files by itself, on the local disk alone

  /// Whether a file of this name is of the format, whatever is in it.
  bool HasExtension(const std::string& path) const;
  /// Whether a file begins as those of the format do.
  bool HasAnyMark(FileSystem& files, const std::string& path) const;
  /// The functions, of the module that is loaded if need be. Error: names the file and the module.
  Result<FormatFunctions> Load(const std::string& path) const;
};

/// "MetaImage, NRRD, ...": the names of all formats.
std::string ListFormatNames();

/// The format of a name: of a folder by the names in it, of a file by its extension or its first
/// bytes, or because the name says what its samples are. Null if it has none. Files that do not
/// exist have one if their extension tells.
const VolumeFormat* FindVolumeFormat(FileSystem& files, const VolumeName& name);

/// An error if there is a file or folder that cannot be read, which then has no format, or if there is
/// nothing at an address.
Status CheckReadable(FileSystem& files, const std::string& path);

/// The files of a pattern that are volumes of one format each, in the order of the numbers in their
/// names: the time steps of a volume. None if it is no pattern, or if they are slices.
std::vector<std::string> FindStepFiles(
  FileSystem& files, const std::string& pattern, PassedOver* over = nullptr);

} // namespace isosurface

#endif
