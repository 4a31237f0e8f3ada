// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockSelection_h
#define isosurface_BlockSelection_h

#include "Volume/BlockGrid.h"
#include "Volume/GridGeometry.h"
#include "Volume/GridSides.h"
#include "Volume/Region.h"

namespace isosurface
{

/**
 * Which blocks an extraction needs other than those that an isovalue crosses: for a surface that is
 * closed at sides of the grid, the blocks there that are inside as a whole, too; within a region,
 * only the blocks that reach into it.
 */
struct BlockSelection
{
  GridSides ClosedSides;
  isosurface::Region Region;

  /// Whether just the crossed blocks are needed, all of them.
  bool IsPlain() const { return this->ClosedSides.IsEmpty() && this->Region.IsEverything(); }

  bool operator==(const BlockSelection& other) const
  {
    return this->ClosedSides == other.ClosedSides && this->Region == other.Region;
  }

  /// Whether a block is needed that the isosurface crosses, or that is inside as a whole.
  bool Selects(const GridGeometry& grid, const VertexBox& vertices, bool isCrossed) const
  {
    return (isCrossed || this->ClosedSides.Touch(vertices, grid.GetDimensions())) &&
      this->Region.Intersects(grid, vertices);
  }
};

} // namespace isosurface

#endif
