// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TriangleNormals_h
#define isosurface_TriangleNormals_h

#include "Surface/Contour/Surface.h"

namespace isosurface
{

/**
 * Computes surface.Normals from the triangles, if the samples for gradients are not available: the
 * mean of the normals of the triangles around each point, weighted by area, scaled to unit length;
 * (0, 0, 0) if there is none. They point to low values, as the normals from gradients do. Cost: one
 * pass over the triangles.
 */
void ComputeNormalsOfTriangles(Surface& surface);

} // namespace isosurface

#endif
