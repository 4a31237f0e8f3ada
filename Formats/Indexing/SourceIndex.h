// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SourceIndex_h
#define isosurface_SourceIndex_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/GridPlace.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

class FetchBudget;
class FinishedLayers;
class SampleCollector;

/// A file of another format, and the blocked volume that is its index: in place, or of a stream, which
/// can only be read in order, a copy.
struct SourceIndex
{
  std::string Source; ///< VolumeName
  std::string Axes;   ///< VolumeChoice::Axes
  std::string Path;   ///< of the .bvol
  GridPlace Place{};  ///< what changes its grid when it is shown; the file has that of the source
  std::shared_ptr<FetchBudget> Fetching{}; ///< of WriteSourceIndex; null: without a limit

  /**
   * Finds the names. `chosen`: a file, a folder of Zarr or N5, or one of the metadata files of such
   * a folder (.zgroup, .zattrs, .zarray, zarr.json, attributes.json), which stands for the folder.
   * Groups and arrays inside a Zarr belong to the outermost folder. `dataset`: what is meant within
   * the file or that folder; empty: what was chosen. `folder`: of the index; empty: beside the
   * source, or, of an address, in the user's cache folder. Of scan.zarr it is scan.zarr.bvol, of run.h5:/entry/data run.h5-entry-data.bvol, of the
   * folder "rock" rock.index.bvol, since rock.bvol is what users call a copy of it.
   */
  static SourceIndex Find(FileSystem& files, const std::string& chosen, const std::string& dataset,
    const std::string& axes, const std::string& folder);
  /// The same of the part that has a box of the world (FindPart), in the grid that `place` gives.
  static Result<SourceIndex> FindPartOf(FileSystem& files, const std::string& chosen,
    const std::string& dataset, const std::string& axes, const std::string& folder,
    const GridPlace& place, const std::optional<std::array<double, 6>>& bounds);

  /// Whether both have the same names.
  bool operator==(const SourceIndex& other) const
  {
    return this->Source == other.Source && this->Axes == other.Axes && this->Path == other.Path;
  }
};

/**
 * Whether a program that opens files should offer to index `chosen` (SourceIndex::Find): it has a
 * volume of more than one slice. So does a damaged file of such a format, of which WriteSourceIndex()
 * tells what is wrong.
 * Cost: reading headers.
 */
bool CanBeIndexed(FileSystem& files, const std::string& chosen);

/// The arrays in `chosen` that have as many axes as a volume may have, by their names (`dataset` of
/// SourceIndex::Find). None if there is but one volume, or if it cannot be read.
std::vector<std::string> ListVolumes(FileSystem& files, const std::string& chosen);

/// Whether `chosen` is a file of which only a person may know what its samples are, and says so as its
/// `dataset`: "512x512x300,uint16" (PlainFormats.h).
bool IsRawSource(FileSystem& files, const std::string& chosen);

/// The values that are black and white in the images of a DICOM series, as the first image with a window
/// says. Nothing if none has one, or it cannot be read. Cost: reading all headers.
std::optional<std::array<double, 2>> FindWindow(FileSystem& files, const SourceIndex& index);

enum class IndexState : std::uint8_t
{
  Missing,
  Current,
  Changed ///< there is one, but the source is no longer as it was
};

/// Looks whether there is an index. Error: InvalidArgument if the file at its path is not an index
/// of this source, so that it must not be replaced.
Result<IndexState> FindIndexState(FileSystem& files, const SourceIndex& index);

/// Whether files can be written where the index will be.
bool CanWriteIndex(FileSystem& files, const SourceIndex& index);

/// Called by WriteSourceIndex before samples are read. Collective.
using WhenSourceIsOpen = std::function<Status(Communicator& ranks, const Progress& advance)>;

/**
 * Collective. Indexes all time steps of a source, its blocks in slabs, or at random where they are
 * copied, over as many stores as there are ranks, and returns what of the source is left out
 * (OpenedVolume::LeftOut). On an error or stop, an older index stays as it was; what was written of
 * this one is kept, too, and the next call goes on there if the source is the same
 * (BlockedVolumeSettings::JournalSeconds).
 * `collector`, if there is one, sees what is read of the first time step. `finished`, which all ranks
 * have or none, is told which blocks of it are finished. `threads`:
 * BlockedVolumeSettings::Threads. Cost and errors: as BlockedVolumeWriter; if SourceIndex::Fetching
 * is spent, as FetchBudget::Run, on all ranks.
 */
Result<std::string> WriteSourceIndex(Communicator& ranks, FileSystem& files,
  const SourceIndex& index, std::uint64_t memoryBytes, const Progress& progress = {},
  SampleCollector* collector = nullptr, FinishedLayers* finished = nullptr, int threads = 0,
  const WhenSourceIsOpen& whenOpen = {});

} // namespace isosurface

#endif
