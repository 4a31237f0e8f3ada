// SPDX-License-Identifier: BSD-3-Clause
#include "RectilinearFixtures.h"

#include "vtkContourFilter.h"
#include "vtkDoubleArray.h"
#include "vtkExtractRectilinearGrid.h"
#include "vtkIdList.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <random>

namespace isosurface
{

vtkSmartPointer<vtkRectilinearGrid> MakeLinedGrid(vtkImageData* image, unsigned int seed)
{
  auto grid = vtkSmartPointer<vtkRectilinearGrid>::New();
  grid->SetExtent(image->GetExtent());
  grid->GetPointData()->ShallowCopy(image->GetPointData());
  std::mt19937 random(seed);
  for (int axis = 0; axis < 3; ++axis)
  {
    vtkNew<vtkDoubleArray> lines;
    double at = -3.0;
    for (int n = 0; n < image->GetDimensions()[axis]; ++n)
    {
      lines->InsertNextValue(at);
      at += 0.1 + static_cast<double>(random() % 1000) / 300.0;
    }
    axis == 0     ? grid->SetXCoordinates(lines)
      : axis == 1 ? grid->SetYCoordinates(lines)
                  : grid->SetZCoordinates(lines);
  }
  return grid;
}

vtkSmartPointer<vtkRectilinearGrid> CutLinedGrid(vtkRectilinearGrid* grid, const Extent& extent)
{
  auto part = vtkSmartPointer<vtkRectilinearGrid>::New();
  part->ShallowCopy(grid);
  part->Crop(extent.data());
  return part;
}

vtkSmartPointer<vtkRectilinearGrid> SubsampleLinedGrid(vtkRectilinearGrid* grid, int level)
{
  vtkNew<vtkExtractRectilinearGrid> extract;
  extract->SetInputData(grid);
  int whole[6];
  grid->GetExtent(whole);
  extract->SetVOI(whole);
  extract->SetSampleRate(1 << level, 1 << level, 1 << level);
  extract->Update();
  // Extents count from the first vertex.
  auto sampled = vtkSmartPointer<vtkRectilinearGrid>::New();
  sampled->ShallowCopy(extract->GetOutput());
  int dimensions[3];
  sampled->GetDimensions(dimensions);
  sampled->SetExtent(0, dimensions[0] - 1, 0, dimensions[1] - 1, 0, dimensions[2] - 1);
  return sampled;
}

vtkStandardNewMacro(LinedGridSource);

int LinedGridSource::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkInformation* information = output->GetInformationObject(0);
  information->Set(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), this->Grid->GetExtent(), 6);
  information->Set(CAN_PRODUCE_SUB_EXTENT(), 1);
  return 1;
}

int LinedGridSource::RequestData(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  Extent extent;
  output->GetInformationObject(0)->Get(
    vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT(), extent.data());
  vtkRectilinearGrid* given = vtkRectilinearGrid::GetData(output, 0);
  given->Initialize();
  if (extent[0] <= extent[1] && extent[2] <= extent[3] && extent[4] <= extent[5])
  {
    given->ShallowCopy(CutLinedGrid(this->Grid, extent));
  }
  return 1;
}

SurfaceCorners TakeTriangles(vtkPolyData* surface)
{
  SurfaceCorners triangles;
  vtkNew<vtkIdList> points;
  for (vtkIdType cell = 0; cell < surface->GetNumberOfCells(); ++cell)
  {
    surface->GetCellPoints(cell, points);
    std::array<SurfaceCorner, 3> triangle;
    for (vtkIdType n = 0; n < 3; ++n)
    {
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        SurfaceCorner& corner = triangle[static_cast<std::size_t>(n)];
        corner[axis] = static_cast<float>(surface->GetPoint(points->GetId(n))[axis]);
        corner[3 + axis] = static_cast<float>(
          surface->GetPointData()->GetNormals()->GetTuple(points->GetId(n))[axis]);
      }
    }
    std::rotate(
      triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
    triangles.insert(triangle);
  }
  return triangles;
}

vtkSmartPointer<vtkPolyData> ContourByStockFilter(vtkRectilinearGrid* grid, double isovalue)
{
  vtkNew<vtkContourFilter> contour;
  contour->SetInputData(grid);
  contour->SetValue(0, isovalue);
  contour->ComputeNormalsOn();
  contour->Update();
  return contour->GetOutput();
}

} // namespace isosurface
