// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceExtractor_h
#define isosurface_SurfaceExtractor_h

#include "Base/Progress.h"
#include "Base/Status.h"
#include "Contour/Surface.h"
#include "Volume/BlockSource.h"
#include "Volume/GridGeometry.h"

#include <cstdint>

namespace isosurface
{

/// The grid whose vertices the global ids count: the blocks' own, or, if a side is closed, the one
/// with a layer of vertices more around it.
GridGeometry GetNumberedGrid(const GridGeometry& geometry, const ContourRequest& request);

/// All global ids of such a request are below this.
std::int64_t CountGlobalIds(const GridGeometry& geometry, const ContourRequest& request);

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
 *   (number in GetNumberedGrid) along `axis`. Equal ids of separate calls on blocks of one grid (of
 *   other ranks, say) with equal requests mean bitwise equal points, normals and attributes.
 * - Connectivity has 32 bits unless there are more than 2^31 - 1 points or entries.
 *
 * DropDegenerateTriangles: points whose structured coordinates are, as floats, those of a vertex of
 * the grid (a sample equals the isovalue, or nearly) become one point, with the vertex's gradient
 * as normal and its values as attributes; triangles with two corners there vanish, and points that
 * no triangle is left of. Triangles of other cells stay as they were, so nothing is torn open: what
 * was closed is closed. It stays a manifold where the inside is thicker than a vertex; sheets that
 * touch are joined there. The point's id is 3 * NumberOfVertices * numberOfIsovalues + vertex +
 * isovalueNumber * NumberOfVertices, above those of all edges: an edge's own id would not do, since
 * the edge may have a point of its own, if the sample is only near the isovalue.
 *
 * ClosedSides: the surface is that of the grid with a layer more at these sides, which is outside,
 * and whose points are moved onto the side. The caps lie in the sides exactly, their normals point
 * outwards; edges where caps meet have a point a cap, and triangles of no area between them. Points
 * that lie on the rim have the normals of the isosurface, as without closing. (With
 * DropDegenerateTriangles, vertices on the sides have one point, with the mean of the sides'
 * outward normals.) Beyond the crossed blocks the source must give those at the sides that are
 * inside as a whole: see BlockSelection. A grid of one vertex on an axis has no surface to close.
 *
 * Errors: InvalidArgument (blocks that do not fit each other or the grid, samples that do not
 * cover what is needed: with Normals, one layer more than the block on every side where the grid
 * has one); whatever Acquire returns first; OutOfMemory;
 * Aborted.
 * Cost: every block is acquired once, from any of `threads` threads, and released before the next
 * one of that thread. Memory beside the result: about 13 KB per 32^3 active cells and isovalue, and
 * per point 4 bytes, 12 with normals, and the attributes. DropDegenerateTriangles: see VertexMerge.
 */
Result<Surface> ExtractSurface(const GridGeometry& geometry, BlockSource& source,
  const ContourRequest& request, int threads, const Progress& progress = {});

} // namespace isosurface

#endif
