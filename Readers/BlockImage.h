// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockImage_h
#define isosurface_BlockImage_h

#include "vtkSmartPointer.h"

#include "Base/Status.h"
#include "Store/BlockedVolume.h"

#include <cstddef>
#include <vector>

class vtkImageData;

namespace isosurface
{

/**
 * A block of a blocked volume as a vtkImageData of its own: the given arrays at a level, with the
 * ghost layer of vertices and cells marked in vtkGhostType. Extent, origin, spacing and direction
 * are those of the level's grid (GridGeometry::Coarsen), so that blocks fit together. May be called
 * from any thread.
 */
Result<vtkSmartPointer<vtkImageData>> ReadBlockImage(BlockedVolume& volume,
  const BlockReference& block, std::size_t timeStep, const std::vector<std::size_t>& arrays,
  int level, QueryStatistics& statistics);

} // namespace isosurface

#endif
