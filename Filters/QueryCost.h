// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_QueryCost_h
#define isosurface_QueryCost_h

#include "Store/LevelChoice.h"
#include "Store/QueryStatistics.h"

#include <cstdint>
#include <optional>

class vtkPolyData;

namespace isosurface
{

/// What a query cost one rank.
struct QueryCost
{
  QueryStatistics Reading;
  std::uint64_t Triangles = 0;
  int Level = 0;                     ///< that the surface was extracted from
  std::optional<LevelChoice> Choice; ///< of the level, within a budget
  double ExtractSeconds = 0; ///< wall clock of extraction, the reading that it waited for included
};

/**
 * Adds what the query cost this rank to the output's field data, one array of one value a quantity:
 * Rank, TreePagesRead, DirectoryPagesRead, ActiveBlocks, BlocksRead, BytesRead, BlockCacheHits,
 * Triangles, Level, QuerySeconds, ReadSeconds, ExtractSeconds. Written as a table, the ranks'
 * values are its rows. Of a level that was chosen within a budget also EstimatedTriangles,
 * PredictedSeconds, and LevelLimit, the name of the property that limits it, or nothing.
 */
void AddCostToFieldData(int rank, const QueryCost& cost, vtkPolyData* output);

} // namespace isosurface

#endif
