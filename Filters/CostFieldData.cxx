// SPDX-License-Identifier: BSD-3-Clause
#include "CostFieldData.h"

#include "Ranks/Query/QueryCost.h"

#include "vtkPolyData.h"
#include "vtkStringArray.h"

namespace isosurface
{

void AddCostToFieldData(int rank, const QueryCost& cost, vtkPolyData* output)
{
  const auto add = [output](const char* name, auto value) { AddToFieldData(output, name, value); };
  add("Rank", rank);
  add("TreePagesRead", cost.Reading.TreePagesRead);
  add("DirectoryPagesRead", cost.Reading.DirectoryPagesRead);
  add("ActiveBlocks", cost.Reading.ActiveBlocks);
  add("BlocksRead", cost.Reading.BlocksRead);
  add("BytesRead", cost.Reading.BytesRead);
  add("BlockCacheHits", cost.Reading.BlockCacheHits);
  add("Triangles", cost.Triangles);
  add("Level", cost.Level);
  add("QuerySeconds", cost.Reading.QuerySeconds);
  add("ReadSeconds", cost.Reading.ReadSeconds);
  add("ExtractSeconds", cost.ExtractSeconds);
  if (!cost.Choice)
  {
    return;
  }
  add("EstimatedTriangles", cost.Choice->Triangles);
  add("PredictedSeconds", cost.Choice->Seconds);
  vtkNew<vtkStringArray> limit;
  limit->SetName("LevelLimit");
  limit->InsertNextValue(cost.Choice->Limit == LevelLimit::Triangles ? "MaximumTriangles"
      : cost.Choice->Limit == LevelLimit::Seconds                    ? "TimeBudget"
                                                                     : "");
  output->GetFieldData()->AddArray(limit);
}

} // namespace isosurface
