// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RectilinearGrids_h
#define isosurface_RectilinearGrids_h

#include "IsosurfaceBridgeModule.h"

#include "vtkSmartPointer.h"

#include "Ground/Volume/GridLines.h"

class vtkImageData;
class vtkRectilinearGrid;

namespace isosurface
{

/// An image in structured coordinates with the extent and the arrays of a grid. It was last modified
/// when the grid was, so what is kept by that time stays valid.
ISOSURFACEBRIDGE_EXPORT vtkSmartPointer<vtkImageData> MakeStructuredImage(vtkRectilinearGrid* grid);

/// The coordinates of a grid.
ISOSURFACEBRIDGE_EXPORT GridLines MakeGridLines(vtkRectilinearGrid* grid);

/// A grid with the arrays and the extent of an image, the vertices of which lie at the given lines:
/// one for each vertex on each axis.
ISOSURFACEBRIDGE_EXPORT vtkSmartPointer<vtkRectilinearGrid> MakeRectilinearGrid(
  vtkImageData* image, const GridLines& lines);

} // namespace isosurface

#endif
