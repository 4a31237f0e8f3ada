// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SourceSegment_h
#define isosurface_SourceSegment_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/QueryStatistics.h"
#include "Storage/Store/SourceSamples.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace isosurface
{

/**
 * Makes the segment of a component of a block of a volume in place: its `header`, which the store
 * has, and the samples from the source. `segment` has room for both. The block has one level, whose
 * samples are not compressed. `path`: the file with the header, for messages. Corrupt if the samples
 * are not those that were indexed; the error names the source.
 */
Status GatherSegment(SourceSamples& source, const BlockGrid& grid, const BlockDirectoryEntry& entry,
  const std::string& path, std::size_t component, const std::uint8_t* header, std::uint8_t* segment,
  QueryStatistics& statistics);

} // namespace isosurface

#endif
