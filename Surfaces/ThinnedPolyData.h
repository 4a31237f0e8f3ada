// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ThinnedPolyData_h
#define isosurface_ThinnedPolyData_h

#include "Surface/Drawing/SurfaceThinning.h"

class vtkPolyData;

namespace isosurface
{

/// How much of a surface a view wants while the camera moves, by its resolution, 0 to 1.
ThinningLimits ChooseThinningLimits(double resolution);

/**
 * Fills `thinned` with the points of a surface that are kept, all their arrays but GlobalIds, and
 * the triangles between them.
 */
void CopyThinned(vtkPolyData* surface, const ThinnedSurface& kept, vtkPolyData* thinned);

} // namespace isosurface

#endif
