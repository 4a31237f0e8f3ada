// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GridLines_h
#define isosurface_GridLines_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"

#include <array>
#include <cstddef>
#include <vector>

namespace isosurface
{

/// Where the vertices of a rectilinear grid lie on each axis, from the grid's first vertex on.
struct GridLines
{
  std::array<std::vector<double>, 3> Coordinates;

  /// Errors (InvalidArgument): lines that do not ascend or are not finite; another number of them
  /// than the grid has vertices on the axis.
  Status Check(const Index3& dimensions) const;

  /// The lines of GridGeometry::Coarsen(level): every 2^level-th, from the first one on.
  GridLines Coarsen(int level) const;

  /// The lines of a box of vertices, counted from the grid's first one.
  GridLines Cut(const VertexBox& box) const;

  /// The coordinate of a vertex; of the nearest one for a vertex beyond the grid.
  double At(std::size_t axis, std::int64_t vertex) const;

  /// A grid of the same dimensions in which a box of vertices takes the same place in the world.
  GridGeometry MakeFrame(const GridGeometry& grid, const VertexBox& box) const;

  bool operator==(const GridLines& other) const { return this->Coordinates == other.Coordinates; }
  bool operator!=(const GridLines& other) const { return !(*this == other); }
};

/// A rectilinear grid, or a piece of one. Origin, spacing and direction have no meaning.
struct LinedGrid
{
  GridGeometry Grid;
  GridLines Lines;
};

/// This rank's pieces, for UniteLinedGrids.
Message PackLinedGrids(const std::vector<LinedGrid>& pieces);

/**
 * The rectilinear grids of which all ranks have pieces; `packed` is what PackLinedGrids gives on each. Pieces that meet belong to one grid if they
 * have the same lines where they meet; its extent is the box around them. The same list on all
 * ranks; `numbers` are those of the pieces of rank `own` in it.
 */
std::vector<LinedGrid> UniteLinedGrids(
  const std::vector<Message>& packed, std::size_t own, std::vector<std::size_t>& numbers);

} // namespace isosurface

#endif
