// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IslandJoin_h
#define isosurface_IslandJoin_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Surface/Islands/IslandMeasures.h"
#include "Surface/Islands/SharedPointIds.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Joins the islands of several ranks, or of several pieces of one rank, that have points with the
 * same global ids. The measures of this rank's islands, in the order of their numbers, become those
 * of the whole islands.
 *
 * `areOwned`: of each island, whether this rank counts it. One rank does, and it does so once.
 *
 * Collective. Errors: OutOfMemory, on all ranks. Cost: each shared point is sent once, 16 bytes, to
 * the rank that compares its id. All ranks get the pairs of islands that meet, 24 bytes each, and
 * the measures of the islands in them; islands within one rank cost nothing.
 */
Status JoinIslands(Communicator& ranks, std::vector<SharedPoint> points,
  std::vector<IslandMeasure>& measures, std::vector<std::uint8_t>& areOwned);

} // namespace isosurface

#endif
