// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeRepair_h
#define isosurface_VolumeRepair_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// What a repair has done.
struct VolumeRepair
{
  std::vector<std::string> Restored; ///< the folders of stores and replicas that were written anew
  std::uint64_t Bytes = 0;           ///< of their files
  std::vector<Status>
    Refused; ///< replicas that cannot be restored: their store, and the blocks that no replica has
};

/**
 * Restores the lost and damaged replicas of stores of a blocked volume, byte for byte, from the
 * others. If no replica of a store is sound, the store is put together of the sound pages of
 * directories and trees, and the sound records. A replica is written beside the damaged one, checked, and its
 * files renamed into place; so a repair may be killed at any time, and the next one goes on.
 * Queries may go on meanwhile. The header stays as it is.
 *
 * Stores with blocks that no replica has are refused; the others are restored nevertheless. Errors:
 * InvalidArgument if the volume has no replicas; IoError if another program writes the volume, or
 * there is no space; Aborted.
 *
 * Cost: reads all replicas once, writes the restored files and reads them once more. Space: that of
 * one replica.
 */
Result<VolumeRepair> RepairBlockedVolume(
  const std::string& path, FileSystem& files, int threads, const Progress& progress = {});

} // namespace isosurface

#endif
