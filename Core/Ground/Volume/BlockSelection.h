// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockSelection_h
#define isosurface_BlockSelection_h

#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/GridSides.h"
#include "Ground/Volume/Region.h"

namespace isosurface
{

/**
 * Which blocks an extraction needs. Usually the active blocks. A surface that is closed at sides of
 * the grid also needs the blocks at these sides that are entirely inside (or entirely outside, if what
 * is beyond the sides is inside). With a region, it needs only blocks that intersect the region.
 */
struct BlockSelection
{
  GridSides ClosedSides;
  isosurface::Region Region;
  const GridLines* Lines = nullptr; ///< of a rectilinear grid

  /// Whether exactly the active blocks are needed.
  bool IsPlain() const { return this->ClosedSides.IsEmpty() && this->Region.IsEverything(); }

  bool operator==(const BlockSelection& other) const
  {
    return this->ClosedSides == other.ClosedSides && this->Region == other.Region &&
      this->Lines == other.Lines;
  }

  /// Whether a block is needed. The block is active, or it is entirely on one side.
  bool Selects(const GridGeometry& grid, const VertexBox& vertices, bool isActive) const
  {
    return (isActive || this->ClosedSides.Touch(vertices, grid.GetDimensions())) &&
      this->Region.Intersects(
        this->Lines ? this->Lines->MakeFrame(grid, vertices) : grid, vertices);
  }
};

} // namespace isosurface

#endif
