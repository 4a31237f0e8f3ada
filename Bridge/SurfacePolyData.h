// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfacePolyData_h
#define isosurface_SurfacePolyData_h

#include "IsosurfaceBridgeModule.h"

#include "Surface/Contour/InterpolatedArray.h"

#include <string>
#include <vector>

class vtkPolyData;

namespace isosurface
{

/**
 * Hands a surface over to a vtkPolyData, without copying: points, polygons, GlobalIds, Normals, the
 * attributes as the arrays that describe them, and, if a name is given, the isovalues as active
 * scalars of that name (float where all isovalues are floats, else double). An attribute with the
 * name of one of these is left out. The surface gives up the memory of its arrays.
 */
ISOSURFACEBRIDGE_EXPORT void MoveToPolyData(Surface& surface,
  const std::vector<InterpolatedArray>& arrays, const std::string& scalarsName,
  vtkPolyData* output);

} // namespace isosurface

#endif
