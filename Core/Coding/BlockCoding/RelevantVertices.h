// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RelevantVertices_h
#define isosurface_RelevantVertices_h

#include "Coding/Prediction/SignRows.h"

#include <array>

namespace isosurface
{

/// The vertices of a slice at which values are coded, by row.
struct RelevantSlice
{
  std::array<SignRow, MaximumCodedVertices> Relevant; ///< ends of crossed edges
  std::array<SignRow, MaximumCodedVertices> Near;     ///< these, and vertices next to them
  bool IsEmpty = true;                                ///< no vertex is relevant
};

/**
 * Finds the relevant vertices of a slice. below, above: the slices beside it, null at the ends of
 * the block. RelevantSlice::Near is set only if `near`. It has the vertices at most one away, in x
 * and in y, from the relevant ones of this slice and from those places (x, y) where an edge within
 * the slice above is crossed.
 */
void FindRelevant(const SignSlice& slice, const SignSlice* below, const SignSlice* above, int sizeX,
  int sizeY, bool near, RelevantSlice& relevant);

} // namespace isosurface

#endif
