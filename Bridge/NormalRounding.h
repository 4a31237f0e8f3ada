// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NormalRounding_h
#define isosurface_NormalRounding_h

#include "IsosurfaceBridgeModule.h" // for the export macro

namespace isosurface
{

struct ContourRequest;

/**
 * Asks for normals that are those of vtkFlyingEdges3D beside which this process runs, to the last
 * bit: sets ContourRequest::NormalsRoundedOnce and NormalsByDirection. How it rounds, VTK itself is
 * asked the first time that this is called. Thread-safe.
 */
ISOSURFACEBRIDGE_EXPORT void MatchNormalsOfVTK(ContourRequest& request);

} // namespace isosurface

#endif
