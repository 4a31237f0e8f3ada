// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GridGeometry_h
#define isosurface_GridGeometry_h

#include "Ground/Volume/LengthUnit.h"

#include <array>
#include <cstdint>

namespace isosurface
{

using Index3 = std::array<std::int64_t, 3>;

/**
 * A regular grid of vertices, as vtkImageData has it. The vertex with structured coordinates
 * (i, j, k), each within Extent, lies at Origin + Direction * (Spacing .* (i, j, k)).
 *
 * Inside Core, vertices are counted from 0 on each axis (index 0 is Extent's low end), x fastest:
 * vertex number = i + Dimensions[0] * (j + Dimensions[1] * k).
 */
struct GridGeometry
{
  std::array<std::int64_t, 6> Extent{ 0, -1, 0, -1, 0, -1 }; ///< x0, x1, y0, y1, z0, z1, inclusive
  std::array<double, 3> Origin{ 0, 0, 0 };
  std::array<double, 3> Spacing{ 1, 1, 1 };
  std::array<double, 9> Direction{ 1, 0, 0, 0, 1, 0, 0, 0, 1 }; ///< row-major
  LengthUnit Unit = LengthUnit::Unknown; ///< of Origin and Spacing, and of grid lines

  /// Vertices on each axis; 0 for an empty extent.
  Index3 GetDimensions() const;
  std::int64_t GetNumberOfVertices() const;

  /// The grid of every 2^level-th vertex, counted from this grid's first one. For level > 0, its
  /// extent begins at 0 and its origin is this grid's first vertex.
  GridGeometry Coarsen(int level) const;

  /// Why vertices have no places that can be told apart: an origin, spacing or direction that is not
  /// finite, a spacing of 0, directions that lie in a plane. Null if they have.
  const char* FindFault() const;

  /// Whether the numbers are equal, whatever their units.
  bool operator==(const GridGeometry& other) const;
  bool operator!=(const GridGeometry& other) const { return !(*this == other); }
};

} // namespace isosurface

#endif
