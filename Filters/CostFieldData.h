// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CostFieldData_h
#define isosurface_CostFieldData_h

class vtkPolyData;

namespace isosurface
{

struct QueryCost;

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
