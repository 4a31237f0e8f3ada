// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfacePolyData_h
#define isosurface_SurfacePolyData_h

#include "Contour/SurfaceExtractor.h"
#include "ImagePieces.h"
#include "Store/LevelChoice.h"
#include "Store/QueryStatistics.h"

#include <optional>
#include <string>
#include <vector>

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
 * Hands a surface over to a vtkPolyData, without copying: points, polygons, GlobalIds, Normals, the
 * attributes as the arrays that describe them, and, if a name is given, the isovalues as active
 * scalars of that name (float where all isovalues are floats, else double). Of arrays of one name
 * those that were computed are kept.
 */
void MoveToPolyData(Surface& surface, const std::vector<InterpolatedArray>& arrays,
  const std::string& scalarsName, vtkPolyData* output);

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
