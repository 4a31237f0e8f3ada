// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PieceOwnership_h
#define isosurface_PieceOwnership_h

#include "Volume/BlockGrid.h"

#include <cstddef>
#include <vector>

namespace isosurface
{

/// What is left of `box` without `hole`: at most six boxes that do not overlap.
std::vector<VertexBox> SubtractBox(const VertexBox& box, const VertexBox& hole);
std::vector<VertexBox> SubtractBox(const std::vector<VertexBox>& boxes, const VertexBox& hole);

/**
 * The vertices that a rank is to supply, as boxes that do not overlap, when the ranks' pieces may:
 * a vertex belongs to the first of the different pieces that has it, and a piece that several ranks
 * have is shared out among them. Over all ranks, each vertex of the union belongs to one rank.
 *
 * Cost: one box subtraction per earlier rank whose piece overlaps this one's.
 */
std::vector<VertexBox> FindOwnedBoxes(const std::vector<VertexBox>& pieces, std::size_t rank);

} // namespace isosurface

#endif
