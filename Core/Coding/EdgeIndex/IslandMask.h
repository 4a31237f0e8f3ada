// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IslandMask_h
#define isosurface_IslandMask_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Volume/BlockSource.h"

#include <cstddef>

namespace isosurface
{

/**
 * The scalars of a block for an encoder with KeptIds, which take fewer bytes: where vertices of one side of the
 * isovalue, or of the other, are enclosed within the block by islands that are left out, and in no cell with an
 * island that is kept, they change sides. So such islands vanish, and others stay as they are.
 *
 * Errors: what ExtractSurface returns.
 */
Result<BlockSamples> MaskIslands(
  const EdgeIndexHeader& header, const BlockSamples& samples, std::size_t isovalue);

} // namespace isosurface

#endif
