// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceFieldData.h"

#include "vtkCellData.h"
#include "vtkIntArray.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"
#include "vtkStringArray.h"

#include "RangedArray.h"

#include <algorithm>

namespace isosurface
{
namespace
{

template <typename ArrayT, typename Row, typename Get>
void AddColumn(const char* name, const std::vector<Row>& rows, const Get& get, vtkPolyData* output)
{
  vtkNew<ArrayT> column;
  column->SetName(name);
  for (const Row& row : rows)
  {
    column->InsertNextValue(static_cast<typename ArrayT::ValueType>(get(row)));
  }
  output->GetFieldData()->AddArray(column);
}

} // namespace

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

void AddBlocks(const SurfaceBlocks& blocks, vtkPolyData* surface)
{
  const vtkSmartPointer<vtkIdTypeArray> ids =
    vtkIdTypeArray::SafeDownCast(surface->GetPointData()->GetGlobalIds());
  if (blocks.Names.empty() || !ids)
  {
    return;
  }
  vtkNew<vtkIntArray> numbers;
  numbers->SetName("BlockIds");
  numbers->SetNumberOfTuples(ids->GetNumberOfTuples());
  for (vtkIdType point = 0; point < ids->GetNumberOfTuples(); ++point)
  {
    const auto next =
      std::upper_bound(blocks.FirstIds.begin(), blocks.FirstIds.end(), ids->GetValue(point));
    const auto grid = static_cast<std::size_t>(next - blocks.FirstIds.begin() - 1);
    numbers->SetValue(point, static_cast<int>(blocks.Numbers[grid]));
  }
  // Ids stay the last array: see MoveToPolyData.
  surface->GetPointData()->RemoveArray(ids->GetName());
  surface->GetPointData()->AddArray(numbers);
  surface->GetPointData()->SetGlobalIds(ids);
  vtkNew<vtkStringArray> names;
  names->SetName("BlockNames");
  for (const std::string& name : blocks.Names)
  {
    names->InsertNextValue(name);
  }
  surface->GetFieldData()->AddArray(names);
}

void AddIslands(ChosenIslands& islands, bool ids, double seconds, vtkPolyData* output)
{
  using OfIsovalue = IsovalueIslands;
  AddColumn<vtkIdTypeArray>(
    "Islands", islands.OfIsovalues, [](const OfIsovalue& one) { return one.Islands; }, output);
  AddColumn<vtkIdTypeArray>(
    "KeptIslands", islands.OfIsovalues, [](const OfIsovalue& one) { return one.KeptIslands; },
    output);
  AddToFieldData(output, "IslandSeconds", seconds);
  using Island = ListedIsland;
  const std::vector<Island>& largest = islands.Largest;
  AddColumn<vtkIdTypeArray>(
    "IslandTriangles", largest, [](const Island& one) { return one.Triangles; }, output);
  AddColumn<vtkDoubleArray>(
    "IslandArea", largest, [](const Island& one) { return one.Area; }, output);
  AddColumn<vtkDoubleArray>(
    "IslandVolume", largest, [](const Island& one) { return one.Volume; }, output);
  const std::vector<IslandBin>& bins = islands.Bins;
  AddColumn<vtkDoubleArray>(
    "IslandBinSize", bins, [](const IslandBin& bin) { return bin.Size; }, output);
  AddColumn<vtkIdTypeArray>(
    "IslandBinIslands", bins, [](const IslandBin& bin) { return bin.Islands; }, output);
  AddColumn<vtkIdTypeArray>(
    "IslandBinTriangles", bins, [](const IslandBin& bin) { return bin.Triangles; }, output);
  if (ids)
  {
    static_assert(sizeof(vtkIdType) == sizeof(std::int64_t), "ids have 64 bits");
    vtkNew<vtkIdTypeArray> ofCells;
    ofCells->SetName("IslandId");
    const auto cells = static_cast<vtkIdType>(islands.Ids.GetSize());
    AdoptMemory(ofCells, islands.Ids.Release(), cells);
    output->GetCellData()->AddArray(ofCells);
  }
}

} // namespace isosurface
