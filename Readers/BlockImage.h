// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockImage_h
#define isosurface_BlockImage_h

#include "vtkSmartPointer.h"

#include "Ground/Base/Buffer.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Storage/Sampling/BlockAssembly.h"
#include "Storage/Store/BlockedVolume.h"

#include <cstddef>
#include <cstdint>
#include <vector>

class vtkDataArray;
class vtkDataSet;
class vtkImageData;

namespace isosurface
{

/// An image of a box of a grid's vertices, without arrays yet.
vtkSmartPointer<vtkImageData> MakeImage(const GridGeometry& geometry, const VertexBox& vertices);

/// Adds a point array, whose tuples are in `memory`, or uninitialised if that is empty; the first one becomes
/// the active scalars.
vtkSmartPointer<vtkDataArray> AddArray(
  vtkImageData* image, const ArrayDescription& description, Buffer<std::uint8_t> memory = {});

/// Stores the ranges of the volume in an array of some of its samples, where VTK keeps those it has
/// computed: a level leaves out most samples, and ranges in panels and color maps are the volume's.
/// Ranges that are empty or not finite are left to VTK. Call it when the samples are there.
void StoreVolumeRanges(
  const BlockedVolume& volume, std::size_t timeStep, std::size_t array, vtkDataArray* values);

/**
 * A box of the blocks that have a level (BlockedVolume::FindLevel) as one vtkImageData, or as one
 * vtkRectilinearGrid if the volume has such a grid, whatever stores the blocks are in: the given arrays at that level, with the ghost layer of vertices and
 * cells marked in vtkGhostType, if there is one. Extent, origin, spacing and direction are those
 * of the level's grid (GridGeometry::Coarsen), so that pieces fit together; its whole extent is in
 * the field data (StoreWholeExtent). Reads the directories of all stores and every block of the box
 * once, on `threads` threads.
 */
Result<vtkSmartPointer<vtkDataSet>> ReadSlab(BlockedVolume& volume, const BlockBox& box,
  std::size_t timeStep, const std::vector<std::size_t>& arrays, int level, int threads,
  QueryStatistics& statistics, const Progress& progress);

/**
 * The box of the whole volume as an image, or as a rectilinear grid, of 2 vertices an axis (1 where the volume has 1), with
 * every component at its minimum in the first vertex and at its maximum in the last. Stands for a
 * volume of which nothing was read: bounds, arrays and the components' ranges are right.
 */
vtkSmartPointer<vtkDataSet> MakeBox(const BlockedVolume& volume, std::size_t timeStep);

} // namespace isosurface

#endif
