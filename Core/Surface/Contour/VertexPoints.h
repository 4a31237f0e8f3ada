// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VertexPoints_h
#define isosurface_VertexPoints_h

#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/GridSides.h"
#include "Surface/Contour/BrickKernel.h"

#include <cstdint>

namespace isosurface
{

/// The axis in the code of a vertex.
constexpr EdgeCode VertexAxis = 3;

/// A point of a brick that lies on a vertex of the grid.
struct VertexPoint
{
  std::uint32_t Point; ///< counted in the brick
  std::uint16_t I;     ///< the vertex, counted in the brick
  std::uint8_t J;
  std::uint8_t K;
  bool IsMerged; ///< an earlier point of the same vertex stands for it; set by VertexMerge
};

/**
 * Finds the points of a brick whose coordinate, as a float (with `areDouble` as a double), is that of
 * an end of their edge.
 * Changes their codes to those of the vertex, with VertexAxis, their coordinates to the vertex's x
 * coordinate and their parameters (if any) to 0. So their positions, normals and attributes are
 * those of the vertex, and do not depend on the edge.
 *
 * points: room for `count` points; returns their number. They are in the order of their numbers.
 */
std::uint32_t FindVertexPoints(const BrickSamples& position, EdgeCode* codes, float* coordinates,
  double* parameters, bool areDouble, std::uint32_t count, VertexPoint* points);

/**
 * Sets the normals of vertices on closed sides of the grid: the mean of the outward normals of
 * these sides. `dimensions` are those of the grid, `low` is the brick's first vertex.
 */
void SetNormalsOnSides(const GridSides& closedSides, const Index3& dimensions, const Index3& low,
  const VertexPoint* points, std::uint32_t count, float* normals);

} // namespace isosurface

#endif
