// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceExtractor_h
#define isosurface_SurfaceExtractor_h

#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockQueue.h"
#include "Ground/Volume/BlockSource.h"
#include "Ground/Volume/GridGeometry.h"
#include "Surface/Contour/Surface.h"

#include <cstdint>

namespace isosurface
{

/// Whether the points of a surface of the grid are float64.
bool HasDoublePoints(const GridGeometry& geometry, const ContourRequest& request);

/// The grid whose vertices the global ids count: the grid of the blocks or, if a side is closed,
/// that grid with one more layer of vertices around it.
GridGeometry GetNumberedGrid(const GridGeometry& geometry, const ContourRequest& request);

/// All global ids of the request are below this number.
std::int64_t CountGlobalIds(const GridGeometry& geometry, const ContourRequest& request);

/**
 * Extracts isosurfaces from blocks of a regular grid by marching cubes: see ContourRequest and
 * Surface. Triangles, points and normals equal those of vtkFlyingEdges3D bit for bit, except where
 * that overflows (see BrickKernel.txx); with Lines those of vtkRectilinearSynchronizedTemplates. The
 * points of all blocks are shared. They are ordered by isovalue, block, row of vertices, axis of the
 * edge, x; so the result does not depend on `threads`.
 *
 * GlobalIds: 3 * vertex + axis + isovalueNumber * 3 * NumberOfVertices for the edge from `vertex`
 * along `axis`, counted in GetNumberedGrid(). If calls for blocks of the same grid, on different
 * ranks, say, have equal requests, then equal ids mean bitwise equal points, normals and
 * attributes.
 *
 * Errors: InvalidArgument (inconsistent blocks, samples that do not cover what is needed), the
 * first error of Acquire(), OutOfMemory, Aborted. Cost: each block is acquired once. Memory beside
 * the result: about 13 KB for 32^3 active cells and isovalue; 4 bytes a point, 12 more with
 * normals, and the attributes; VertexMerge.
 */
Result<Surface> ExtractSurface(const GridGeometry& geometry, BlockSource& source,
  const ContourRequest& request, int threads, const Progress& progress = {});

/// The same of those blocks alone that a queue hands out during the extraction, in the order of
/// their numbers in the source: bit for bit the surface of a source that has no others. Errors:
/// also those of the queue.
Result<Surface> ExtractQueuedSurface(const GridGeometry& geometry, BlockSource& source,
  const ContourRequest& request, BlockQueue& queue, int threads, const Progress& progress = {});

} // namespace isosurface

#endif
