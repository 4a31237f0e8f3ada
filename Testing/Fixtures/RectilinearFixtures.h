// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RectilinearFixtures_h
#define isosurface_RectilinearFixtures_h

#include "TestImages.h"

#include "vtkPolyData.h"
#include "vtkRectilinearGrid.h"
#include "vtkRectilinearGridAlgorithm.h"

#include <array>
#include <set>

namespace isosurface
{

/// A grid with the samples of an image and lines at uneven distances on each axis. The same for the
/// same arguments.
vtkSmartPointer<vtkRectilinearGrid> MakeLinedGrid(vtkImageData* image, unsigned int seed = 1);

/// A part of a grid, with its lines.
vtkSmartPointer<vtkRectilinearGrid> CutLinedGrid(vtkRectilinearGrid* grid, const Extent& extent);

/// Every 2^level-th vertex of a grid, from its first one.
vtkSmartPointer<vtkRectilinearGrid> SubsampleLinedGrid(vtkRectilinearGrid* grid, int level);

/// Gives the pieces of a grid that it is asked for, as readers of large files do.
class LinedGridSource : public vtkRectilinearGridAlgorithm
{
public:
  static LinedGridSource* New();
  vtkTypeMacro(LinedGridSource, vtkRectilinearGridAlgorithm);

  vtkSmartPointer<vtkRectilinearGrid> Grid;

protected:
  LinedGridSource() { this->SetNumberOfInputPorts(0); }
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
};

/// The surface of vtkContourFilter, with normals.
vtkSmartPointer<vtkPolyData> ContourByStockFilter(vtkRectilinearGrid* grid, double isovalue);

/// Triangles, corner by corner: position and normal. The corners begin with the least one.
using SurfaceCorner = std::array<float, 6>;
using SurfaceCorners = std::multiset<std::array<SurfaceCorner, 3>>;
SurfaceCorners TakeTriangles(vtkPolyData* surface);

} // namespace isosurface

#endif
