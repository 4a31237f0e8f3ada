// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VertexPlaces_h
#define isosurface_VertexPlaces_h

#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"

#include <array>
#include <optional>

namespace isosurface
{

/**
 * Finds where points of the world lie among the vertices of a grid. A vertex coordinate counts
 * vertices from 0 at the grid's first one; fractions lie between vertices.
 */
class VertexPlaces
{
public:
  /// A regular grid without a fault (GridGeometry::FindFault), or, with lines, a rectilinear one.
  /// Copies both.
  explicit VertexPlaces(const GridGeometry& grid, const GridLines* lines = nullptr);

  /// The vertex coordinates of a point, also of one beyond the grid. On an axis of one vertex it is
  /// 0 at the vertex, and not 0 elsewhere.
  std::array<double, 3> FindVertex(const std::array<double, 3>& point) const;
  /// The point with these vertex coordinates.
  std::array<double, 3> FindPoint(const std::array<double, 3>& vertex) const;

private:
  GridGeometry Grid;
  std::optional<GridLines> Lines;
  std::array<double, 9> ToVertex{}; ///< row-major, the inverse of Direction * Spacing
};

} // namespace isosurface

#endif
