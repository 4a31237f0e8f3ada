// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockIslands_h
#define isosurface_BlockIslands_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"
#include "Surface/Contour/Surface.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// A connected part of the surface that a block has alone; all of it is on one island of the whole surface.
struct BlockIsland
{
  std::int64_t FirstId = 0; ///< the minimum of the global ids of its points
  std::uint64_t Points = 0;
  bool IsKept = true;
};

/// What a stream's surface is extracted by, with GlobalIds.
ContourRequest MakeContourRequest(const EdgeIndexHeader& header);

/// Global ids of a surface that was extracted for one isovalue become those among all of them: ids of edges are
/// before those of vertices.
void ShiftIds(const EdgeIndexHeader& header, std::size_t isovalue, Buffer<std::int64_t>& ids);

/// The surface that a block has alone, at one isovalue, with GlobalIds.
Result<Surface> ExtractBlockSurface(
  const EdgeIndexHeader& header, const BlockSamples& samples, std::size_t isovalue);

/// The islands of a block at one isovalue, in the order of their FirstId. `samples`: those to encode, or decoded
/// ones. Errors: what ExtractSurface returns.
Result<std::vector<BlockIsland>> FindBlockIslands(
  const EdgeIndexHeader& header, const BlockSamples& samples, std::size_t isovalue);

/// Drops the islands of `surface`, which has GlobalIds and is of several blocks, whose parts in `told` are not
/// kept. Errors: Corrupt, if `told` keeps one part of an island and not another.
Status KeepBlockIslands(const std::vector<BlockIsland>& told, int threads, Surface& surface);

} // namespace isosurface

#endif
