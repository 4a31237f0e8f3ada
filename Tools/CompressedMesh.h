// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CompressedMesh_h
#define isosurface_CompressedMesh_h

#include "Coding/Meshes/MeshFile.h"

namespace isosurface
{

/// That of meshoptimizer.
extern const MeshCompression MeshoptimizerCompression;

} // namespace isosurface

#endif
