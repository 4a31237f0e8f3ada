// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PointPlaces_h
#define isosurface_PointPlaces_h

#include "Drawing/TriangleSurface.h"

#include <cstddef>

namespace isosurface
{

/// 1 if two points, given by their coordinates, are in one place, else 0. A NaN is in no place.
[[gnu::always_inline]] inline int AreInOnePlace(const float* a, const float* b)
{
  // An int, and no branches: the processor could not predict which coordinates are equal.
  return (a[0] == b[0]) & (a[1] == b[1]) & (a[2] == b[2]);
}

/// Whether a triangle has three points in different places. VTK's mappers draw only such triangles.
template <typename T>
[[gnu::always_inline]] inline bool IsProperTriangle(const float* points, const T* triangle)
{
  const float* a = points + 3 * static_cast<std::size_t>(triangle[0]);
  const float* b = points + 3 * static_cast<std::size_t>(triangle[1]);
  const float* c = points + 3 * static_cast<std::size_t>(triangle[2]);
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
