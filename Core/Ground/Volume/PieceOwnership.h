// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PieceOwnership_h
#define isosurface_PieceOwnership_h

#include "Ground/Volume/BlockGrid.h"

#include <cstddef>
#include <vector>

namespace isosurface
{

/// Returns `box` without `hole`, as at most six boxes that do not overlap.
std::vector<VertexBox> SubtractBox(const VertexBox& box, const VertexBox& hole);
std::vector<VertexBox> SubtractBox(const std::vector<VertexBox>& boxes, const VertexBox& hole);

/// A box of vertices, and which of some pieces supplies them.
struct Supply
{
  std::size_t Piece = 0;
  VertexBox Box;
};

/// Takes each vertex of the boxes in `missing` from the first piece that has it. Vertices that
/// no piece has are left in `missing`.
std::vector<Supply> FindSupplies(
  const std::vector<VertexBox>& pieces, std::vector<VertexBox>& missing);

/**
 * Finds the vertices that a rank owns, as boxes that do not overlap. The ranks' pieces may overlap:
 * a vertex belongs to the first piece that contains it. Ranks with the same piece divide it among
 * them. So each vertex of the union belongs to exactly one rank.
 *
 * Cost: one box subtraction for each earlier piece that overlaps this rank's.
 */
std::vector<VertexBox> FindOwnedBoxes(const std::vector<VertexBox>& pieces, std::size_t rank);

} // namespace isosurface

#endif
