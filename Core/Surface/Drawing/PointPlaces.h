// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PointPlaces_h
#define isosurface_PointPlaces_h

#include "Surface/Drawing/PointVector.h"
#include "Surface/Drawing/TriangleSurface.h"

#include <cstddef>

namespace isosurface
{

/// A point by its number; behind the last one there is no fourth float.
inline PointVector LoadPoint(const TriangleSurface& surface, std::size_t number)
{
  const float* point = surface.Points + 3 * number;
  return number + 1 < surface.NumberOfPoints ? PointVector::Load(point)
                                             : PointVector(point[0], point[1], point[2]);
}

/// Whether the corners of a triangle are in three places. VTK's mappers draw only such triangles.
[[gnu::always_inline]] inline bool AreProperCorners(PointVector a, PointVector b, PointVector c)
{
  // No branches: the processor could not predict which points are in one place.
  return (AreInOnePlace(a, b) | AreInOnePlace(b, c) | AreInOnePlace(a, c)) == 0;
}

/// Calls body(point numbers) with those of the two arrays that is there.
template <typename BodyT>
void WithConnectivity(const TriangleConnectivity& connectivity, BodyT&& body)
{
  if (connectivity.Values32)
  {
    body(connectivity.Values32);
  }
  else
  {
    body(connectivity.Values64);
  }
}

} // namespace isosurface

#endif
