// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreCheck_h
#define isosurface_StoreCheck_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// The faults of one replica of a store of a volume or an overview, in its folder; the samples of a
/// volume in place are not looked at. Cost: reads all of its files once. Memory: as that of
/// VerifyBlockedVolume.
std::vector<Status> CheckStore(FileSystem& files, const BlockedVolumeHeader& header,
  const TimeStepDescription& step, std::uint32_t store, const std::string& folder, int threads);

/// Ok if the replicas of a store have all of it together, though none may have it alone; else what
/// is lost, in one line with the blocks. `folders`: of the replicas. Cost: reads all of them.
Status CheckReplicas(FileSystem& files, const BlockedVolumeHeader& header,
  const TimeStepDescription& step, std::uint32_t store, const std::vector<std::string>& folders,
  int threads);

} // namespace isosurface

#endif
