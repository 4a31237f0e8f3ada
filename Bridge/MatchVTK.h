// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MatchVTK_h
#define isosurface_MatchVTK_h

#include "IsosurfaceBridgeModule.h" // for the export macro

namespace isosurface
{

struct ContourRequest;

/**
 * Asks for a surface as the VTK that this process runs beside has it and takes it. Normals are those
 * of its vtkFlyingEdges3D, to the last bit: sets ContourRequest::NormalsRoundedOnce and
 * NormalsByDirection. How it rounds, VTK itself is asked the first time that this is called. Before
 * VTK 9.4, some filters find no neighbours among cells with ids of 32 bits
 * (vtkLoopSubdivisionFilter): sets WideIndices. Thread-safe.
 */
ISOSURFACEBRIDGE_EXPORT void MatchVTK(ContourRequest& request);

} // namespace isosurface

#endif
