// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BorderBrick_h
#define isosurface_BorderBrick_h

#include "Contour/BrickKernel.h"
#include "Contour/BrickLattice.h"
#include "Volume/BlockSource.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

// A brick beyond the grid (Brick::IsBeyond) closes the surface: its outer vertices are outside,
// the points on its edges, which all lead outwards, lie on their inner vertex.

/// The samples of the block at the border, as the brick has them: across the border all of its
/// vertices have the sample of the inner one.
BlockSamples ExtendBeyond(const BlockSamples& samples, const Brick& brick);

/// Clears the bits of the outer vertices in the brick's words.
void ClearOuterVertices(const Brick& brick, std::uint64_t* inside);

/// The structured coordinate along each edge, and a part of the edge that yields the inner vertex's
/// values.
void LocateBorderPoints(const Brick& brick, const BrickSamples& position, const EdgeCode* codes,
  std::uint32_t count, float* coordinates, double* parameters);

/// The normals of edges that lead outwards: their directions.
void ComputeOutwardNormals(
  const Brick& brick, const EdgeCode* codes, std::uint32_t count, float* normals);

} // namespace isosurface

#endif
