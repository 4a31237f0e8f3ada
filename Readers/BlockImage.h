// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockImage_h
#define isosurface_BlockImage_h

#include "vtkSmartPointer.h"

#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Storage/Store/BlockAssembly.h"
#include "Storage/Store/BlockedVolume.h"

#include <cstddef>
#include <vector>

class vtkDataSet;

namespace isosurface
{

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
