// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Handedness_h
#define isosurface_Handedness_h

#include "Ground/Volume/GridGeometry.h"

#include <algorithm>

namespace isosurface
{

/// Whether the direction of a grid has a negative determinant.
inline bool HasMirroredDirection(const GridGeometry& grid)
{
  const std::array<double, 9>& d = grid.Direction;
  return d[0] * (d[4] * d[8] - d[5] * d[7]) - d[1] * (d[3] * d[8] - d[5] * d[6]) +
    d[2] * (d[3] * d[7] - d[4] * d[6]) <
    0;
}

/// Whether the steps from vertex to vertex on x, y and z are left-handed in the world: a mirrored
/// direction, or one or three negative spacings; but not both.
inline bool IsLeftHanded(const GridGeometry& grid)
{
  const auto negative = std::count_if(
    grid.Spacing.begin(), grid.Spacing.end(), [](double spacing) { return spacing < 0; });
  return HasMirroredDirection(grid) != (negative % 2 == 1);
}

} // namespace isosurface

#endif
