// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceMemory_h
#define isosurface_SurfaceMemory_h

#include "Surface/Contour/Surface.h"

#include <cstddef>
#include <vector>

namespace isosurface
{

/// The share of free memory that a surface may take.
constexpr double UsableMemoryShare = 0.8;

/**
 * Estimates the memory in bytes that a triangle of a surface needs until it is shown: its arrays,
 * its share of the points', the pieces that extraction joins, and a copy for drawing. A closed
 * surface has one point for two triangles.
 */
double EstimateBytesPerTriangle(const ContourRequest& request);

/**
 * Finds the first of surfaces, the largest first, that fits into UsableMemoryShare of `freeBytes`.
 * If none fits, it is the last one; if `freeBytes` is 0 (unknown), the first. There is at least one.
 */
std::size_t FindFittingSurface(const std::vector<double>& bytes, double freeBytes);

} // namespace isosurface

#endif
