// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreReplication_h
#define isosurface_StoreReplication_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <cstdint>
#include <string>

namespace isosurface
{

/// Copies a finished store of the last time step of `header`, which may be that of an overview, to
/// the folders of other stores, as many as it has replicas there, and brings the copies to stable
/// storage. `path`: that of the volume. Cost: one pass over the store's files for each replica.
/// Memory: a MiB.
Status ReplicateStore(FileSystem& files, const std::string& path, const BlockedVolumeHeader& header,
  std::uint32_t store);

} // namespace isosurface

#endif
