// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PointRestriction_h
#define isosurface_PointRestriction_h

#include "Surface/Contour/BrickKernel.h"
#include "Surface/Contour/BrickScan.h"
#include "Surface/Contour/Surface.h"

#include <cstddef>
#include <vector>

namespace isosurface
{

/// Moves what a part has of a point to the place of an earlier one.
void MovePoint(const BrickPart& part, const std::vector<AttributeLayout>& attributes,
  std::size_t from, std::size_t to);

/// Memory for RestrictPoints, of one thread, which is used again.
struct RestrictionMemory
{
  std::vector<EdgeCode> Edges;
  std::vector<EdgeCode> Kept;
};

/**
 * Drops those points of a brick that it does not own any more, in place: the part is then what it
 * were if it had been made with the ownership `after`, which has no edge that `before` does not
 * have. `vertices` are those of the brick. Cost: the rows are numbered once more, twice if points
 * were moved to vertices.
 */
void RestrictPoints(const VertexBox& vertices, const BrickOwnership& before,
  const BrickOwnership& after, const std::vector<AttributeLayout>& attributes, BrickPart& part,
  RestrictionMemory& memory);

} // namespace isosurface

#endif
