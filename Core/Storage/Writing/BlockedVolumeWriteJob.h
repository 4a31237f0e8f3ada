// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolumeWriteJob_h
#define isosurface_BlockedVolumeWriteJob_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BoxSource.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Writing/BlockedVolumeWriter.h"
#include "Storage/Writing/ResolutionWriter.h"
#include "Storage/Writing/WriteContext.h"
#include "Storage/Writing/WriteJournal.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

/// One write of a time step: locks the volume, writes the stores of the volume and its overviews,
/// then makes them visible.
class BlockedVolumeWriteJob
{
public:
  BlockedVolumeWriteJob(Communicator& ranks, FileSystem& files, std::string path, BoxSource& source,
    const BlockedVolumeSettings& settings, Progress progress)
    : Context(ranks, files, std::move(path), settings)
    , Source(source)
    , Tell(std::move(progress))
  {
  }

  /// Collective. `pending`: the volume to append to, if it is not the one on disk.
  Result<WriteStatistics> Run(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    const std::optional<BlockedVolumeHeader>& pending);

  /// The lock of the volume's folder, on rank 0. Run() takes it unless it is held already.
  void HoldLock(std::unique_ptr<PathLock> lock) { this->Lock = std::move(lock); }
  std::unique_ptr<PathLock> TakeLock() { return std::move(this->Lock); }

  /// Whether a later write can go on with what is on disk. Known in Run().
  bool KeepsJournal() const { return this->Context.Settings.JournalSeconds.has_value(); }
  /// After Run(): what was written, with the time steps before.
  const BlockedVolumeHeader& GetHeader() const { return this->Volume->GetHeader(); }

private:
  Status LockVolume();
  void WarnOfLackOfRoom() const;
  void ReadJournal();
  Result<BlockedVolumeHeader> Plan(const GridGeometry& grid,
    const std::vector<ArrayDescription>& arrays,
    const std::optional<BlockedVolumeHeader>& existing);
  Status WriteVolume(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    const std::optional<BlockedVolumeHeader>& pending);
  Status Prepare(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    const std::optional<BlockedVolumeHeader>& pending);
  Status CheckBox(const GridGeometry& grid) const;
  /// A checksum of all that has to be the same on all ranks.
  std::uint64_t ComputeFingerprint(const BlockedVolumeHeader& header) const;
  /// InvalidArgument for this reason if the ranks have different numbers.
  Status CheckEqual(std::uint64_t mine, const char* reason) const;
  Status CheckSourceFiles() const;
  Status MakeGeneration();
  Status WriteOverviews();
  Result<std::unique_ptr<ResolutionWriter>> WriteOverview(
    std::size_t overview, ResolutionWriter& finer);
  Status Commit();
  /// Progress within [begin, end] of the whole work.
  Progress MakeProgress(double begin, double end) const;

  WriteContext Context;
  BoxSource& Source;
  Progress Tell;
  std::unique_ptr<ResolutionWriter> Volume;
  std::unique_ptr<PathLock> Lock; ///< of rank 0
  std::string NewFolder;          ///< of rank 0; empty until it is made
  WriteJournal Journal;           ///< of an earlier write, until this one makes its own
  bool HasJournal = false;        ///< whether an earlier write of the same has left one
  bool IsFinished = false;        ///< whether that write has finished the time step
  bool IsVisible = false;
  WriteStatistics Statistics;
};

} // namespace isosurface

#endif
