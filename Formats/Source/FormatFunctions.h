// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FormatFunctions_h
#define isosurface_FormatFunctions_h

#include "Ground/Volume/VolumeName.h"
#include "Ground/Volume/VolumeOpener.h"

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// The most time steps that a file may have: the list of their times is made from a header alone.
constexpr std::int64_t MaximumTimeSteps = std::int64_t{ 1 } << 20;

/// What is in a file: a dataset of HDF5, a variable of NetCDF, an array of Zarr, a series of DICOM.
struct VolumeListing
{
  std::string Name;    ///< what stands behind the colon of a VolumeName
  std::string Shape;   ///< samples on each axis, the slowest first: "3 x 100 x 512 x 512"
  std::string Type;    ///< "float32", "string"
  std::string Storage; ///< how the samples lie in the file: "chunks of 64 x 64 x 64, gzip"
};

/// How files of a format are read.
struct FormatFunctions
{
  Result<OpenedVolume> (*Open)(
    FileSystem& files, const VolumeName& name, const VolumeChoice& choice) = nullptr;
  /// Null: a file has one volume.
  Result<std::vector<VolumeListing>> (*List)(FileSystem& files, const VolumeName& name) = nullptr;
};

} // namespace isosurface

#endif
