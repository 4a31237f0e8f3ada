// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IslandKeeping_h
#define isosurface_IslandKeeping_h

#include "Surface/Contour/Surface.h"
#include "Surface/Islands/IslandLabels.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Drops the points and cells of the islands that are not kept, by island. The kept ones stay in
/// their order, bit for bit, in indices as wide as before. Memory meanwhile: the largest of the new
/// arrays, and an index a point. Throws std::bad_alloc; the surface is then lost.
void KeepIslands(const IslandLabels& labels, const std::vector<std::uint8_t>& areKept, int threads,
  Surface& surface);

/// Drops the triangles with a point that is infinite or not a number, and then the points without
/// triangles; in the same way. Returns how many triangles were dropped. No polygons.
std::size_t KeepFiniteTriangles(int threads, Surface& surface);

} // namespace isosurface

#endif
