// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumePlan_h
#define isosurface_VolumePlan_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// The volume that a time step is appended to: `pending`, if it is there, else the one on disk;
/// nothing if the time step is the first one. InvalidArgument if the settings do not allow it.
Result<std::optional<BlockedVolumeHeader>> FindVolumeToAppendTo(FileSystem& files,
  const std::string& path, const BlockedVolumeSettings& settings,
  const std::optional<BlockedVolumeHeader>& pending);

/**
 * Plans the header of the volume that a write makes. Its last time step is the new one, of which
 * the time alone is known. A new volume gets its levels: two in the records of the volume's own
 * blocks, the next two in those of an overview, and so on until an overview is a single block,
 * which has the remaining levels. `existing`: the volume that is appended to; it keeps its levels.
 * `ranks`: the number of stores of a new volume if the settings leave it open. InvalidArgument if
 * the settings or the time step do not fit.
 */
Result<BlockedVolumeHeader> PlanVolume(const std::string& path, const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays, const BlockedVolumeSettings& settings,
  const std::optional<BlockedVolumeHeader>& existing, std::size_t ranks);

/// The bytes of the records of a planned time step, those of its overviews and replicas included, if
/// they cannot be compressed. Directories, trees and spectra add a few in a thousand.
std::uint64_t CountRecordBytes(const BlockedVolumeHeader& planned);

} // namespace isosurface

#endif
