// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockSelection_h
#define isosurface_BlockSelection_h

#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/GridSides.h"
#include "Ground/Volume/Region.h"
#include "Ground/Volume/VertexBox.h"

#include <optional>

namespace isosurface
{

/**
 * Which blocks an extraction needs. Usually the active blocks. A surface that is closed at sides of
 * the grid also needs the blocks at these sides that are entirely inside (or entirely outside, if what
 * is beyond the sides is inside). With a region, it needs only blocks that intersect the region.
 * Of a part of the grid, it needs only blocks with cells there, and of these only those cells.
 */
struct BlockSelection
{
  GridSides ClosedSides;
  isosurface::Region Region;
  const GridLines* Lines = nullptr; ///< of a rectilinear grid
  std::optional<VertexBox> Part{};  ///< vertices of the level

  /// Whether exactly the active blocks are needed.
  bool IsPlain() const
  {
    return this->ClosedSides.IsEmpty() && this->Region.IsEverything() && !this->Part;
  }

  bool operator==(const BlockSelection& other) const
  {
    return this->ClosedSides == other.ClosedSides && this->Region == other.Region &&
      this->Part == other.Part && this->Lines == other.Lines;
  }

  /// Whether a block has cells in the part.
  bool IsInPart(const VertexBox& vertices) const
  {
    const Index3 size = this->Part ? vertices.Intersect(*this->Part).GetSize() : Index3{ 2, 2, 2 };
    return size[0] > 1 && size[1] > 1 && size[2] > 1;
  }

  /// Whether a block is needed. The block is active, or it is entirely on one side.
  bool Selects(const GridGeometry& grid, const VertexBox& vertices, bool isActive) const
  {
    return this->IsInPart(vertices) &&
      (isActive || this->ClosedSides.Touch(vertices, grid.GetDimensions())) &&
      this->Region.Intersects(
        this->Lines ? this->Lines->MakeFrame(grid, vertices) : grid, vertices);
  }
};

} // namespace isosurface

#endif
