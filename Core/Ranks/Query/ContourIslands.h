// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContourIslands_h
#define isosurface_ContourIslands_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ranks/Query/ContourBlocks.h"

namespace isosurface
{

/**
 * If blocks.Islands is set: finds the islands of the surface that the blocks of all ranks have, and of its preview, and
 * lets the header leave out those that the filter does not keep. A closed surface becomes lossless then. If all are
 * kept, the header stays as it is.
 *
 * Collective. Errors of any rank: what ExtractSurface and ChooseIslands return. Memory: this rank's part of the whole
 * surface; then 8 bytes for each of its points that is kept.
 */
Status LeaveOutIslands(Communicator& ranks, const ContourBlocks& blocks, int threads,
  const Progress& progress, EdgeIndexHeader& header);

} // namespace isosurface

#endif
