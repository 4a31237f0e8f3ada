// SPDX-License-Identifier: BSD-3-Clause
#include "RectilinearGrids.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkImageData.h"
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

} // namespace isosurface
