// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeOpener_h
#define isosurface_VolumeOpener_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"

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
  std::size_t Step = 0;            ///< number of the time step
  std::string Axes;                ///< of a dataset, a letter each; empty: as it says
  bool IgnoresPlaces = false;      ///< whether the caller places the samples, on a regular grid
  bool IsRecorded = false;         ///< whether a volume names it, perhaps with axes without effect
  std::vector<std::string> Arrays; ///< names; empty: all. Unknown names choose nothing
  bool WantsAttributes = false;    ///< whether to fill OpenedVolume::Attributes
  /// Of a pyramid, chooses the finest level of at most Vertices, or the coarsest; 0: the finest.
  std::int64_t Vertices = 0;
  /// What decoded chunks may take between reads.
  std::uint64_t CacheBytes = std::uint64_t{ 256 } << 20;
  bool ReadsChunks = false; ///< whether most boxes are whole chunks, which are read once
};

/// A volume in files of another format, opened for reading.
struct OpenedVolume
{
  GridGeometry Grid;
  std::optional<GridLines> Lines;       ///< of a rectilinear grid; then Grid tells its extent alone
  std::vector<ArrayDescription> Arrays; ///< the components of each have views of their own
  std::unique_ptr<BoxSource> Source;
  std::vector<double> Times;      ///< of all time steps of the file; empty if it has none
  int Level = 0;                  ///< of a pyramid; above 0, samples are averages
  std::string LeftOut;            ///< says what of the file is not read; empty if everything is
  std::vector<std::string> Files; ///< that have the samples, or folders of them
  /// On request, of HDF5, Zarr and N5: the attributes of the dataset, of an image in Zarr also those of
  /// its group, as an object of JSON. A value of another type than text, numbers or lists of them is null.
  std::string Attributes;
  std::string Storage; ///< the file's own words of how it stores the samples; perhaps empty
};

/**
 * Opens a volume by its name (VolumeName.h). Core knows no format of others: a program that reads
 * their files hands an opener to the functions that need one. It is Formats/Opener/ForeignVolume.h's
 * OpenForeignVolume. Null: such files are not read.
 */
using VolumeOpener = Result<OpenedVolume> (*)(
  FileSystem& files, const std::string& name, const VolumeChoice& choice);

} // namespace isosurface

#endif
