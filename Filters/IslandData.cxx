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

#include <array>
#include <cstddef>
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

std::string SummariseIslands(const ChosenIslands* islands, const std::vector<double>& isovalues)
{
  std::string summary;
  if (!islands)
  {
    return summary;
  }
  const std::vector<IsovalueIslands>& all = islands->OfIsovalues;
  for (std::size_t n = 0; n < all.size(); ++n)
  {
    std::array<char, 64> text{};
    if (all.size() > 1 && n < isovalues.size())
    {
      std::snprintf(text.data(), text.size(), "%s%g: ", n > 0 ? "; " : "", isovalues[n]);
      summary += text.data();
    }
    const auto triangles = static_cast<double>(all[n].Triangles);
    std::snprintf(text.data(), text.size(), "%.1f",
      triangles > 0 ? 100 * static_cast<double>(all[n].KeptTriangles) / triangles : 100.0);
    summary += GroupDigits(all[n].KeptIslands) + " of " + GroupDigits(all[n].Islands) +
      " islands, " + text.data() + " % of the triangles";
  }
  return summary;
}

} // namespace isosurface
