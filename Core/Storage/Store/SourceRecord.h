// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SourceRecord_h
#define isosurface_SourceRecord_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/VolumeOpener.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// Files that samples are read from, and their state when that began.
struct SourceFiles
{
  std::vector<std::string> Paths; ///< OpenedVolume::Files
  FileState State;

  static Result<SourceFiles> Find(FileSystem& files, std::vector<std::string> paths);
};

/**
 * Where the samples at full resolution of a time step are, if the blocked volume itself has none
 * (a volume in place): in a file of another format, as it was when it was indexed. Or, as "copyOf",
 * the file that the volume's own samples were copied from.
 *
 *     "source": { "path": string, "absolutePath": string, "within": string, "axes": string,
 *                 "step": integer, "arrays": [string, ...], "chunk": [x, y, z], unless it is a stream,
 *                 "files": integer, "bytes": integer, "modified": integer, "metadata": hex }
 */
struct SourceRecord
{
  /// Of a folder with more files, a change of its chunks is found when they are read.
  static constexpr std::uint64_t MaximumFilesToCheck = 4096;
  static constexpr std::int64_t MaximumChunk = std::int64_t{ 1 } << 31; ///< on an axis

  std::string Path;                ///< seen from the folder of the header
  std::string AbsolutePath;        ///< where it was when it was indexed
  std::string Within;              ///< VolumeName::Within
  std::string Axes;                ///< VolumeChoice::Axes
  std::size_t Step = 0;            ///< number of the time step in the source
  std::vector<std::string> Arrays; ///< the source's own names of the volume's arrays
  std::optional<Index3> Chunk;     ///< BoxSource::GetChunk() of the first array
  FileState State;                 ///< of all files that have the samples
  std::uint64_t Metadata = 0;      ///< checksum of shape, types, chunks and storage

  /// What to open in the source for some of its arrays.
  VolumeChoice MakeChoice(const std::vector<std::string>& arrays) const;

  /// BlockCacheKey::Dataset of the source's chunks, whichever volume has them in place.
  std::uint64_t ComputeDataset() const;

  /// The source's path seen from the current folder: Path, or else AbsolutePath, whichever exists;
  /// the first one if neither does. `header`: the path of the .bvol.
  std::string FindPath(FileSystem& files, const std::string& header) const;

  /// Checks what can be checked without the source. Error: a sentence without a file.
  Status Validate() const;
};

/// Opens a source. `header`: the volume whose samples it has. Unsupported if there is no opener.
Result<OpenedVolume> OpenSource(FileSystem& files, VolumeOpener opener, const std::string& header,
  const std::string& name, const VolumeChoice& choice);

/**
 * Describes a source for the blocked volume `header`. `name`: as the user gives it (VolumeName).
 * `wanted`: its Axes, Step and Arrays choose from the source; if the source lacks a name but has as
 * many arrays, all are chosen. `arrays`: the types and components that the chosen arrays must have.
 * Errors name the source: NotFound, InvalidArgument if it has other arrays or another size than
 * `grid`.
 */
Result<SourceRecord> DescribeSource(FileSystem& files, VolumeOpener opener,
  const std::string& header, const std::string& name, const SourceRecord& wanted,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays);

/// Ok if a source is as it was when it was indexed. Otherwise one error that names it, tells what
/// is not, and what to do: NotFound, Corrupt if it was changed. Cost: a look at its files, or at its
/// metadata alone if there are more than MaximumFilesToCheck.
Status CheckSource(FileSystem& files, VolumeOpener opener, const std::string& header,
  const SourceRecord& record, const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays);

/// The part of CheckSource that looks at the source's files (OpenedVolume::Files) alone.
Status CheckSourceFiles(FileSystem& files, const std::string& header, const std::string& name,
  const SourceRecord& record, const std::vector<std::string>& paths);

/// Of all these files and folders.
Result<FileState> FindStateOfAll(FileSystem& files, const std::vector<std::string>& paths);

/// The path seen from the folder of the header, for SourceRecord::Path.
std::string MakeRelativePath(const std::string& header, const std::string& path);

} // namespace isosurface

#endif
