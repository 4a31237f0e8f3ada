// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfacePolyData_h
#define isosurface_SurfacePolyData_h

#include "IsosurfaceBridgeModule.h"

#include "Surface/Contour/Surface.h"

#include <string>
#include <vector>

class vtkPolyData;

namespace isosurface
{

/// A point array of the surface.
struct InterpolatedArray
{
  std::string Name;
  std::vector<std::string> ComponentNames; ///< of all components, or none
  AttributeLayout Layout;

  /// Names of components may differ.
  ISOSURFACEBRIDGE_EXPORT bool operator==(const InterpolatedArray& other) const;
};

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
