// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ActiveBlocks_h
#define isosurface_ActiveBlocks_h

#include "Ranks/Sharing/QueryPlan.h"

#include <utility>
#include <vector>

namespace isosurface
{

/// The blocks that one rank reads for a query: { { time step, variable, isovalues, selection }, rank,
/// ranks }; the last three may be missing.
inline Result<std::vector<BlockReference>> FindActiveBlocks(
  BlockedVolume& volume, const SurfaceQuery& query, QueryStatistics& statistics, int level = 0)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto plan, PlanQuery(volume, query, level, statistics));
  return std::move(plan.Blocks);
}

} // namespace isosurface

#endif
