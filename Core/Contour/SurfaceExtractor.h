// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceExtractor_h
#define isosurface_SurfaceExtractor_h

#include "Base/Progress.h"
#include "Base/Status.h"
#include "Contour/BlockSource.h"
#include "Contour/Surface.h"
#include "Volume/GridGeometry.h"

namespace isosurface
{

/**
 * Marching cubes (Lorensen and Cline 1987, SIGGRAPH) on blocks of a regular grid, by bits: one bit
 * a vertex (value >= isovalue, so NaN is outside), one 64-bit word a row of up to 33 vertices.
 * XORs of words are the crossed grid edges, AND and OR of four words the active cells, popcounts
 * number the points. Triangles, points and normals equal those of vtkFlyingEdges3D (Schroeder,
 * Maynard and Geveci 2015, LDAV), bit for bit but where that overflows (see BrickKernel.txx).
 *
 * - Points are shared by all blocks of the call. An edge on a face that blocks of the call share
 *   is given a point by one of them: the one with the greatest lattice coordinates (z first).
 * - Order: isovalue, block as the source counts, rows of vertices, axis of the edge, x. Hence the
 *   result does not depend on `threads`.
 * - GlobalIds: 3 * vertex + axis + isovalueNumber * 3 * NumberOfVertices, of the edge from `vertex`
 *   (number in the whole grid) along `axis`. Equal ids of separate calls on blocks of one grid (of
 *   other ranks, say) mean bitwise equal points, normals and attributes.
 * - Connectivity has 32 bits unless there are more than 2^31 - 1 points or entries.
 *
 * Errors: InvalidArgument (blocks that do not fit each other or the grid, samples that do not
 * cover what is needed: with Normals, one layer more than the block on every side where the grid
 * has one); whatever Acquire returns first; OutOfMemory;
 * Aborted.
 * Cost: every block is acquired once, from any of `threads` threads, and released before the next
 * one of that thread. Memory beside the result: about 13 KB per 32^3 active cells and isovalue, and
 * per point 4 bytes, 12 with normals, and the attributes.
 */
Result<Surface> ExtractSurface(const GridGeometry& geometry, BlockSource& source,
  const ContourRequest& request, int threads, const Progress& progress = {});

} // namespace isosurface

#endif
