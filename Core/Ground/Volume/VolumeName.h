// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeName_h
#define isosurface_VolumeName_h

#include "Ground/Base/FileSystem.h"

#include <string>

namespace isosurface
{

/// The name of a volume: a file or a folder, and perhaps a dataset in it behind a colon
/// ("run.h5:/entry/data", "climate.nc:temperature").
struct VolumeName
{
  std::string Path;
  std::string Within; ///< empty: the file says what to take

  /// Splits at the last colon before which there is a file, folder or pattern. A name that exists as it
  /// stands, or of which nothing exists, is a path as a whole. An address is split at its last colon behind
  /// the host, whatever exists.
  static VolumeName Parse(FileSystem& files, const std::string& text);

  /// "path:within", or "path".
  std::string GetText() const
  {
    return this->Within.empty() ? this->Path : this->Path + ":" + this->Within;
  }
};

} // namespace isosurface

#endif
