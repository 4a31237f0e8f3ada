// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NormalRounding_h
#define isosurface_NormalRounding_h

#include "IsosurfaceBridgeModule.h" // for the export macro

namespace isosurface
{

/**
 * Whether the VTK of this process rounds the normals of images once, when it transforms them to world
 * coordinates (ContourRequest::NormalsRoundedOnce). VTK itself is asked, the first time that this is
 * called. Thread-safe.
 */
ISOSURFACEBRIDGE_EXPORT bool RoundsNormalsOnce();

} // namespace isosurface

#endif
