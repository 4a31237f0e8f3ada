// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeCollapse_h
#define isosurface_EdgeCollapse_h

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Collapses edges of a mesh, those first that move the surface least, until it has at most the
 * wanted number of triangles. The points that are left stay where they are. Error: the quadrics of
 * M. Garland and P. S. Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH
 * 1997.
 *
 * Topology is kept: an edge is collapsed only if that joins no other points and triangles (the link
 * condition: T. K. Dey et al., "Topology preserving edge contraction", Publ. Inst. Math. 66, 1999), so
 * a manifold stays one, and a closed surface stays closed. Points on open sides, and those where the
 * mesh is no manifold, stay. So there may be more triangles than wanted.
 *
 * `corners`: three numbers of points a triangle; becomes that of the triangles that are left. Memory:
 * about 250 bytes a point.
 */
void CollapseEdges(const float* points, std::size_t numberOfPoints, std::size_t triangles,
  std::vector<std::uint32_t>& corners);

} // namespace isosurface

#endif
