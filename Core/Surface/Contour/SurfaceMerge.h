// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceMerge_h
#define isosurface_SurfaceMerge_h

#include "Surface/Contour/SurfaceExtractor.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Merges surfaces that were extracted from parts of a grid with equal requests and GlobalIds.
 * Points with equal global ids are bitwise equal, and become one. The result is ordered by
 * isovalue, then by surface. It has Offsets if all surfaces have them, and indices of 64 bits if one
 * of them has these or the result needs them.
 *
 * Cost: a hash table entry for each point, and a copy of everything. Meant for the pieces of a
 * composite dataset; within one call, ExtractSurface() shares points itself.
 */
Surface MergeSurfaces(const std::vector<Surface>& surfaces);

/// The same of one or more surfaces that have no point in common, without a table and GlobalIds.
Surface JoinSurfaces(std::vector<Surface> surfaces);

/// Adds a number to all GlobalIds, so that the ids of several grids follow each other.
void ShiftGlobalIds(std::int64_t shift, Surface& surface);

} // namespace isosurface

#endif
