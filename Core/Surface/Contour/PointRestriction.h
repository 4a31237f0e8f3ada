// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PointRestriction_h
#define isosurface_PointRestriction_h

#include "Surface/Contour/BrickKernel.h"
#include "Surface/Contour/BrickScan.h"
#include "Surface/Contour/Surface.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Moves the data of `count` points of a part from `from` to the earlier place `to`.
void MovePoints(const BrickSurface& part, const std::vector<AttributeLayout>& attributes,
  std::size_t from, std::size_t to, std::size_t count);

/**
 * Drops the points of a brick that it does not own any more, in place: `part` is then as if it had
 * been made with the ownership `after`, which must be a subset of `before`.
 * `vertices` are those of the brick; `dropped` is memory that is used again. Cost: the rows
 * on the faces that are shared now, and moving the points behind the first one that is dropped.
 */
void RestrictPoints(const VertexBox& vertices, const BrickOwnership& before,
  const BrickOwnership& after, const std::vector<AttributeLayout>& attributes, BrickSurface& part,
  std::vector<std::uint32_t>& dropped);

} // namespace isosurface

#endif
