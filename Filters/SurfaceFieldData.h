// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceFieldData_h
#define isosurface_SurfaceFieldData_h

#include "vtkDataSet.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
#include "vtkNew.h"

#include "Ranks/Islands/IslandChoice.h"
#include "Ranks/Query/LevelExtraction.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

class vtkPolyData;

namespace isosurface
{

/// Adds an array of one number to the output's field data.
template <typename T>
void AddToFieldData(vtkDataSet* output, const char* name, T value)
{
  using Array = std::conditional_t<std::is_floating_point_v<T>, vtkDoubleArray, vtkIdTypeArray>;
  vtkNew<Array> array;
  array->SetName(name);
  array->InsertNextValue(static_cast<typename Array::ValueType>(value));
  output->GetFieldData()->AddArray(array);
}

/**
 * Adds what the query cost this rank to the output's field data, one array of one value a quantity:
 * Rank, TreePagesRead, DirectoryPagesRead, ActiveBlocks, BlocksRead, BytesRead, BlockCacheHits,
 * Triangles, Level, QuerySeconds, ReadSeconds, ExtractSeconds. Written as a table, the ranks'
 * values are its rows. Of a level that was chosen within a budget also EstimatedTriangles,
 * PredictedSeconds, and LevelLimit, the name of the property that limits it, or nothing.
 */
void AddCostToFieldData(int rank, const QueryCost& cost, vtkPolyData* output);

/// Which block of a composite each part of a surface is of. The same on all ranks.
struct SurfaceBlocks
{
  std::vector<std::int64_t> FirstIds; ///< of the grids: the first id of each
  std::vector<std::size_t> Numbers;   ///< of the grids, into Names
  std::vector<std::string> Names;
};

/// Adds to a surface which block of a composite each of its points is of: the point array BlockIds,
/// and the field array BlockNames, which has the name of each number. Nothing for a single block.
void AddBlocks(const SurfaceBlocks& blocks, vtkPolyData* surface);

/// Adds what was found to the output's field data (see vtkStabbingContour::SetMinimumIslandSize),
/// and the ids of the cells, if there are any, whose memory the output takes.
void AddIslands(ChosenIslands& islands, bool ids, double seconds, vtkPolyData* output);

} // namespace isosurface

#endif
