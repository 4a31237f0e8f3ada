// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceThinning_h
#define isosurface_SurfaceThinning_h

#include "Surface/Drawing/TriangleMeasure.h"
#include "Surface/Drawing/TriangleSurface.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// How much of a surface is kept.
struct ThinningLimits
{
  int Cells = 110;            ///< along the longest side of the surface's bounds; at most 512
  std::size_t Points = 80000; ///< the maximum number of points, roughly
};

/// Some points of a surface, and triangles between them.
struct ThinnedSurface
{
  std::vector<std::uint32_t> Points;    ///< their numbers in the surface
  std::vector<std::uint32_t> Triangles; ///< three indices in Points each
  std::vector<std::uint32_t> Numbers;   ///< of the triangles in the surface
};

/**
 * Thins a surface by a grid of cubic cells over its bounds. Of the points in a cell the one next to
 * its centre is kept, the first of several; of the triangles those whose corners are in three cells.
 * So what is kept are points of the surface itself, with its own normals and attributes. If every
 * eighth point shows that more points than wanted would be kept, cells are made larger. The result
 * does not depend on the number of threads.
 *
 * Cost: a visit to each point and triangle, and to some points to choose the cells. Memory: 4 bytes
 * a point, 8 a cell. The measure is that of the surface, and valid; a surface has at most 2^32 - 1
 * points. After: J. Rossignac, P. Borrel, "Multi-resolution 3D approximations for rendering complex
 * scenes", 1993.
 */
ThinnedSurface ThinSurface(const TriangleSurface& surface, const TriangleMeasure& measure,
  const ThinningLimits& limits, int threads);

} // namespace isosurface

#endif
