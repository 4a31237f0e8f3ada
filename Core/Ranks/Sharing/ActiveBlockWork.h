// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ActiveBlockWork_h
#define isosurface_ActiveBlockWork_h

#include "Ground/Volume/BlockGrid.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Predicts the triangles of active blocks, up to a factor, from nothing but which blocks are active. A
 * surface that crosses a face of a block makes the block behind it active, too; so a block whose
 * neighbours are active on both sides of two axes has a sheet through its middle, and one with few
 * active neighbours has a corner cut off. The weights are a fit to 52 isosurfaces of eleven volumes
 * (Documentation/dev/load-balance.md); the prediction correlates with the triangles at 0.56.
 *
 * `blocks`: numbers in the grid, ascending. The result is positive. Cost: 26 look-ups a block in a
 * bit map of the box around the blocks; where that had more than 2^28 bits, all have equal work.
 */
std::vector<std::int64_t> PredictActiveBlockWork(
  const BlockGrid& grid, const std::vector<std::int64_t>& blocks);

} // namespace isosurface

#endif
