// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BorderBrick_h
#define isosurface_BorderBrick_h

#include "Ground/Volume/BlockSource.h"
#include "Surface/Contour/BrickKernel.h"
#include "Surface/Contour/BrickLattice.h"

#include <cstdint>

namespace isosurface
{

// A brick beyond the grid (Brick::IsBeyond) closes the surface. Its outer vertices are on one side. Its
// crossed edges lead outwards; their points lie on their inner vertices.

/// The samples of the brick, from those of the block at the border: an outer vertex has the sample
/// of the inner vertex next to it.
BlockSamples ExtendBeyond(const BlockSamples& samples, const Brick& brick);

/// Sets or clears the bits of the outer vertices in the brick's inside words.
void SetOuterVertices(const Brick& brick, bool areInside, std::uint64_t* inside);

/// As BrickKernels::LocatePoints: the structured coordinate of each point, and the parameter of the
/// inner vertex.
void LocateBorderPoints(const Brick& brick, const BrickSamples& position, const EdgeCode* codes,
  std::uint32_t count, float* coordinates, double* parameters);

/// The normals of the points: the outward directions of their edges.
void ComputeOutwardNormals(
  const Brick& brick, const EdgeCode* codes, std::uint32_t count, float* normals);

} // namespace isosurface

#endif
