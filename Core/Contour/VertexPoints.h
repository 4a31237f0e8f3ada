// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VertexPoints_h
#define isosurface_VertexPoints_h

#include "Contour/BrickKernel.h"
#include "Volume/BlockGrid.h"
#include "Volume/GridSides.h"

#include <cstdint>

namespace isosurface
{

/// What an edge code names as its axis if it stands for a vertex.
constexpr EdgeCode VertexAxis = 3;

/// A point of a brick that lies on a vertex of the grid.
struct VertexPoint
{
  std::uint32_t Point; ///< counted in the brick
  std::uint16_t I;     ///< the vertex, counted in the brick
  std::uint8_t J;
  std::uint8_t K;
  bool IsMerged; ///< an earlier point stands for it; set by VertexMerge
};

/**
 * Finds the points of a brick whose coordinate is, as a float, that of an end of their edge. Their
 * codes become those of the vertex, with VertexAxis, their coordinates the vertex's x coordinate,
 * their parameters (if any) 0. So what is made of them, position, normal and attributes, is that of
 * the vertex, whatever edge led there.
 *
 * points: room for `count`; returns how many there are, in the order of their numbers.
 */
std::uint32_t FindVertexPoints(const BrickSamples& position, EdgeCode* codes, float* coordinates,
  double* parameters, std::uint32_t count, VertexPoint* points);

/**
 * Gives the vertices on closed sides of the grid the normal that points out of all those sides.
 * `dimensions` are the grid's, low is the brick's first vertex.
 */
void SetNormalsOnSides(const GridSides& closedSides, const Index3& dimensions, const Index3& low,
  const VertexPoint* points, std::uint32_t count, float* normals);

} // namespace isosurface

#endif
