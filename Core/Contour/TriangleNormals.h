// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TriangleNormals_h
#define isosurface_TriangleNormals_h

#include "Contour/Surface.h"

namespace isosurface
{

/**
 * Fills surface.Normals for a surface of triangles that has none of the samples' gradients: at each
 * point the unit vector along the sum of the cross products of the triangles around, that is, their
 * mean normal by area; (0, 0, 0) where there is none. Triangles are seen from the side of low
 * values, so it points the same way as a gradient's. Cost: a pass over the triangles.
 */
void ComputeNormalsOfTriangles(Surface& surface);

} // namespace isosurface

#endif
