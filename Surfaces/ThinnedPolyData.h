// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ThinnedPolyData_h
#define isosurface_ThinnedPolyData_h

#include "MeasuredTriangles.h"

class vtkPolyData;

namespace isosurface
{

/**
 * Fills `thinned` with a part of a surface's points, all their arrays but GlobalIds, and triangles
 * between them: what is shown while the camera moves. `resolution` is a view's, 0 to 1: the higher,
 * the more is kept. `triangles` has measured the surface.
 */
void ThinPolyData(vtkPolyData* surface, const MeasuredTriangles& triangles, double resolution,
  int threads, vtkPolyData* thinned);

} // namespace isosurface

#endif
