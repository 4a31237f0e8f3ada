// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeFile_h
#define isosurface_VolumeFile_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/SlabSource.h"
#include "Ground/Volume/ValueType.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// What to read of a file that has more than one volume.
struct VolumeChoice
{
  std::size_t Step = 0;       ///< number of the time step
  std::string Axes;           ///< of a dataset, a letter each (ArrayAxes::Parse); empty: as it says
  bool IgnoresPlaces = false; ///< whether the caller places the samples, on a regular grid
  std::vector<std::string> Arrays; ///< names; empty: all. Unknown names choose nothing
  /// What decoded chunks may take between reads.
  std::uint64_t CacheBytes = std::uint64_t{ 256 } << 20;
};

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

/**
 * A volume in files, opened by a name (VolumeName.h). VolumeFormat.h tells how formats are
 * recognised; Documentation/dev/sources.md, what is read of each.
 *
 * The files of a TIFF stack are sorted by the numbers in their names ("slice9.tif" before
 * "slice10.tif"). If they differ in one number only, it must increase by equal steps: otherwise a
 * slice is missing.
 */
struct VolumeFile
{
  GridGeometry Grid;
  std::optional<GridLines> Lines;       ///< of a rectilinear grid; then Grid tells its extent alone
  std::vector<ArrayDescription> Arrays; ///< the components of each have views of their own
  std::unique_ptr<SlabSource> Source;
  std::vector<double> Times;      ///< of all time steps of the file; empty if it has none
  std::string LeftOut;            ///< says what of the file is not read; empty if everything is
  std::vector<std::string> Files; ///< that have the samples, or folders of them
  std::string Storage; ///< the file's own words of how it stores the samples; perhaps empty

  /// Whether Open() supports the name. Looks at folders and at the first bytes of files.
  static bool IsKnown(FileSystem& files, const std::string& name);

  /// Opens a volume. Unsupported if not IsKnown(), or if this build lacks the library. `files` must
  /// outlive the source. HDF5, NetCDF and DICOM are read from the local file system, whatever
  /// `files` is. Cost: reading the headers; for a TIFF stack, the directories of all pages.
  static Result<VolumeFile> Open(
    FileSystem& files, const std::string& name, const VolumeChoice& choice = {});

  /// What is in a file or a folder of HDF5, NetCDF, Zarr or DICOM. Unsupported for others.
  static Result<std::vector<VolumeListing>> List(FileSystem& files, const std::string& name);

  /// The files of a stack in their order, or the file itself. NotFound if there are none, Corrupt
  /// if one is missing.
  static Result<std::vector<std::string>> FindStack(FileSystem& files, const std::string& path);
};

} // namespace isosurface

#endif
