// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockData_h
#define isosurface_BlockData_h

class vtkPolyData;

namespace isosurface
{

struct SurfaceBlocks;

/// Adds to a surface which block of a composite each of its points is of: the point array BlockIds,
/// and the field array BlockNames, which has the name of each number. Nothing for a single block.
void AddBlocks(const SurfaceBlocks& blocks, vtkPolyData* surface);

} // namespace isosurface

#endif
