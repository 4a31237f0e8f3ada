// SPDX-License-Identifier: BSD-3-Clause
#include "RectilinearGrids.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkImageData.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkRectilinearGrid.h"

namespace isosurface
{
namespace
{

// An image that is as old as the grid it stands for.
class StructuredImage : public vtkImageData
{
public:
  static StructuredImage* New();
  vtkTypeMacro(StructuredImage, vtkImageData);

  vtkMTimeType GetMTime() override
  {
    return this->Grid ? this->Grid->GetMTime() : this->Superclass::GetMTime();
  }

  vtkSmartPointer<vtkRectilinearGrid> Grid;
};
vtkStandardNewMacro(StructuredImage);

} // namespace

vtkSmartPointer<vtkImageData> MakeStructuredImage(vtkRectilinearGrid* grid)
{
  const auto image = vtkSmartPointer<StructuredImage>::New();
  image->SetExtent(grid->GetExtent());
  image->GetPointData()->ShallowCopy(grid->GetPointData());
  image->GetCellData()->ShallowCopy(grid->GetCellData());
  image->GetFieldData()->ShallowCopy(grid->GetFieldData());
  image->Grid = grid;
  return image;
}

GridLines MakeGridLines(vtkRectilinearGrid* grid)
{
  GridLines lines;
  vtkDataArray* const coordinates[3] = { grid->GetXCoordinates(), grid->GetYCoordinates(),
    grid->GetZCoordinates() };
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    for (vtkIdType n = 0; coordinates[axis] && n < coordinates[axis]->GetNumberOfTuples(); ++n)
    {
      lines.Coordinates[axis].push_back(coordinates[axis]->GetComponent(n, 0));
    }
  }
  return lines;
}

vtkSmartPointer<vtkRectilinearGrid> MakeRectilinearGrid(vtkImageData* image, const GridLines& lines)
{
  auto grid = vtkSmartPointer<vtkRectilinearGrid>::New();
  grid->SetExtent(image->GetExtent());
  vtkNew<vtkDoubleArray> axes[3];
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    for (const double line : lines.Coordinates[axis])
    {
      axes[axis]->InsertNextValue(line);
    }
  }
  grid->SetXCoordinates(axes[0]);
  grid->SetYCoordinates(axes[1]);
  grid->SetZCoordinates(axes[2]);
  grid->GetPointData()->ShallowCopy(image->GetPointData());
  grid->GetCellData()->ShallowCopy(image->GetCellData());
  grid->GetFieldData()->ShallowCopy(image->GetFieldData());
  return grid;
}

} // namespace isosurface
