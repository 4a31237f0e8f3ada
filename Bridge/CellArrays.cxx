// SPDX-License-Identifier: BSD-3-Clause
#include "CellArrays.h"

#include "ImageSamples.h"
#include "RangedArray.h"

#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkImageData.h"

#include "Ground/Volume/CellAverage.h"

#include <algorithm>

namespace isosurface
{
namespace
{

// Refined cells have values like others. As for the stock filter, they are left out only where some
// cells are hidden.
bool HidesCells(const Blanking& hidden, vtkIdType count)
{
  return hidden.Cells &&
    std::any_of(hidden.Cells, hidden.Cells + count,
      [](std::uint8_t flag) { return (flag & vtkDataSetAttributes::HIDDENCELL) != 0; });
}

} // namespace

Result<vtkSmartPointer<vtkDataArray>> AverageToPoints(
  vtkImageData* image, vtkDataArray* cells, int threads)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const ValueType type, GetValueTypeOf(cells));
  if (cells->GetNumberOfTuples() != image->GetNumberOfCells())
  {
    return Status(StatusCode::InvalidArgument,
      std::string("cell array \"") + (cells->GetName() ? cells->GetName() : "") + "\" has " +
        std::to_string(cells->GetNumberOfTuples()) + " values for " +
        std::to_string(image->GetNumberOfCells()) + " cells");
  }
  const vtkSmartPointer<vtkDataArray> plain = MakePlainArray(cells);
  const auto points =
    vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(cells->GetDataType()));
  points->SetName(cells->GetName());
  points->SetNumberOfComponents(cells->GetNumberOfComponents());
  points->CopyComponentNames(cells);
  AllocateTuples(points, image->GetNumberOfPoints());

  // In coordinates of the image's own extent.
  const GridGeometry grid = MakeGridGeometry(image, image->GetExtent());
  CellTuples tuples;
  tuples.Type = type;
  tuples.NumberOfComponents = cells->GetNumberOfComponents();
  tuples.First = plain->GetVoidPointer(0);
  tuples.Box = MakeVertexBox(grid, image->GetExtent());
  Blanking hidden = FindBlanking(grid, image);
  if (!HidesCells(hidden, image->GetNumberOfCells()))
  {
    hidden.Cells = nullptr;
  }
  AverageCells(tuples, hidden, tuples.Box, threads, points->GetVoidPointer(0));
  return points;
}

Result<vtkDataArray*> CellAverages::Find(
  vtkImageData* image, vtkMTimeType imageTime, vtkDataArray* cells, int threads)
{
  const vtkMTimeType time = std::max(imageTime, cells->GetMTime());
  for (Entry& entry : this->Entries)
  {
    if (entry.Cells == cells && entry.Time == time)
    {
      entry.IsUsed = true;
      return entry.Points.Get();
    }
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto points, AverageToPoints(image, cells, threads));
  this->Entries.push_back({ cells, time, points, true });
  return this->Entries.back().Points.Get();
}

void CellAverages::DropUnused()
{
  this->Entries.erase(std::remove_if(this->Entries.begin(), this->Entries.end(),
                        [](const Entry& entry) { return !entry.IsUsed; }),
    this->Entries.end());
  for (Entry& entry : this->Entries)
  {
    entry.IsUsed = false;
  }
}

std::string ListArrays(vtkDataSetAttributes* attributes)
{
  std::string names;
  for (int index = 0; index < attributes->GetNumberOfArrays(); ++index)
  {
    vtkDataArray* array = attributes->GetArray(index);
    const std::string name = array && array->GetName() ? array->GetName() : "";
    if (array && name != vtkDataSetAttributes::GhostArrayName())
    {
      names += (names.empty() ? "\"" : ", \"") + name + "\"";
    }
  }
  return names;
}

} // namespace isosurface
