// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CostFieldData_h
#define isosurface_CostFieldData_h

#include "vtkDataSet.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
#include "vtkNew.h"

#include <type_traits>

class vtkPolyData;

namespace isosurface
{

struct QueryCost;

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

} // namespace isosurface

#endif
