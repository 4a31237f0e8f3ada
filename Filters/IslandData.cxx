// SPDX-License-Identifier: BSD-3-Clause
#include "IslandData.h"

#include "CostFieldData.h"

#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
#include "vtkNew.h"
#include "vtkPolyData.h"

#include "RangedArray.h"

#include <cstdio>
#include <vector>

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

std::string GroupDigits(std::uint64_t number)
{
  std::string digits = std::to_string(number);
  for (std::size_t end = digits.size(); end > 3; end -= 3)
  {
    digits.insert(end - 3, ",");
  }
  return digits;
}

} // namespace

void AddIslands(ChosenIslands& islands, bool ids, double seconds, vtkPolyData* output)
{
  AddToFieldData(output, "Islands", islands.Islands);
  AddToFieldData(output, "KeptIslands", islands.KeptIslands);
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

std::string SummariseIslands(const ChosenIslands* islands)
{
  if (!islands)
  {
    return "all are shown";
  }
  char share[16];
  std::snprintf(share, sizeof(share), "%.1f",
    islands->Triangles > 0
      ? 100 * static_cast<double>(islands->KeptTriangles) / static_cast<double>(islands->Triangles)
      : 100.0);
  return GroupDigits(islands->KeptIslands) + " of " + GroupDigits(islands->Islands) + " islands, " +
    share + " % of the triangles";
}

} // namespace isosurface
