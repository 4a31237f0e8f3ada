// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VertexPlaces_h
#define isosurface_VertexPlaces_h

#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/VertexBox.h"

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

  /// The grid's vertices around a box of the world, given by opposite corners: all in the box and,
  /// unless a face lies on vertices, the next ones beyond it. If the grid's axes are not the world's,
  /// those around all of the box's corners. Empty if the box is beside the grid. Rounding errors of
  /// less than a millionth of a cell do not count.
  VertexBox FindVerticesAround(
    const std::array<double, 3>& corner, const std::array<double, 3>& opposite) const;

private:
  GridGeometry Grid;
  std::optional<GridLines> Lines;
  std::array<double, 9> ToVertex{}; ///< row-major, the inverse of Direction * Spacing
};

} // namespace isosurface

#endif
