// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockPacking_h
#define isosurface_BlockPacking_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"
#include "Ranks/Redistribution/ArrivingBlocks.h"
#include "Ranks/Redistribution/BlockDescription.h"
#include "Surface/Contour/Surface.h"

#include <functional>

namespace isosurface
{

/// Takes the edge-index records of one block, one for each isovalue that crosses it.
using TakeBlock = std::function<Status(BlockDescription block, Message bytes)>;

/**
 * Encodes the blocks of a source and calls `take` for each, from the calling thread, in the order
 * of the source. Blocks without a surface are left out.
 *
 * Errors: InvalidArgument (the header has a preview, the samples do not fit it), what Acquire or
 * `take` returns, Aborted, OutOfMemory.
 */
Status PackBlocks(const EdgeIndexHeader& header, BlockSource& source, int threads,
  const TakeBlock& take, const Progress& progress);

/**
 * The surface of blocks that arrive as PackBlocks made them. Each block is decoded when marching
 * cubes visits it, and waited for if it is not there yet; points that blocks share are made once.
 * request: see JoinIsovalues.
 *
 * Errors: Corrupt, OutOfMemory, Aborted (also if a block never comes); throws std::bad_alloc.
 */
Result<Surface> UnpackBlocks(const EdgeIndexHeader& header, const ContourRequest& request,
  ArrivingBlocks& blocks, int threads, const Progress& progress);

} // namespace isosurface

#endif
