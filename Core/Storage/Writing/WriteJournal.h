// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WriteJournal_h
#define isosurface_WriteJournal_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <cstdint>
#include <optional>
#include <string>

namespace isosurface
{

/**
 * What is on stable storage of a write that is not finished, so that a later one goes on there: the
 * file .NAME.bvol.stores/journal, JSON as the header of a volume, replaced by a rename. It names a
 * checkpoint that the journals of all stores have (StoreJournal), so it is written after these. The
 * number of ranks does not matter.
 */
struct WriteJournal
{
  /// The volume with those time steps that are finished and not published.
  std::optional<BlockedVolumeHeader> Finished;
  std::uint32_t NumberOfStores = 1;
  /// The time step in progress: its folder, a checksum of the header as planned, how many blocks
  /// are written, from the first one on, and the number of the checkpoint.
  std::string Folder;
  std::uint64_t Plan = 0;
  std::int64_t Blocks = 0;
  std::int64_t Checkpoint = 0;

  static std::string GetPath(FileSystem& files, const std::string& volumePath);
  static std::uint64_t ComputePlan(const BlockedVolumeHeader& planned);

  /// Replaces the file.
  Status Write(FileSystem& files, const std::string& volumePath) const;
  static Result<std::string> ReadText(FileSystem& files, const std::string& volumePath);
  /// Parses the text of the file. Errors name `path`: Corrupt, Unsupported.
  static Result<WriteJournal> Parse(const std::string& text, const std::string& path);

  /// Whether the last time step of a header is the one in progress.
  bool IsInProgress(const BlockedVolumeHeader& planned) const
  {
    return this->Blocks > 0 && this->Plan == ComputePlan(planned);
  }
  /// The planned volume as it was written, if its last time step is finished.
  std::optional<BlockedVolumeHeader> FindFinished(const BlockedVolumeHeader& planned) const;
};

} // namespace isosurface

#endif
