// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfacePieces_h
#define isosurface_SurfacePieces_h

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Ground/Volume/VertexBox.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// A part of a surface that is decoded at once: the blocks with cells in a box.
struct SurfacePiece
{
  VertexBox Box;
  std::uint64_t NumberOfPoints = 0; ///< as the directory counts them, block by block
  bool BeginsLayer = false;         ///< no piece before it reaches as far up the z axis
};

/**
 * Cuts a surface into pieces of at most `points` points, at planes that cut no block: first into
 * layers along z, then what is still too large into rows along y. A row of blocks along x is not cut,
 * however many points it has. Pieces come in the order of z, then y; two of them have points in
 * common only at the end of a layer, or at the end of the piece before.
 */
std::vector<SurfacePiece> CutSurface(const EdgeIndexFile& file, std::uint64_t points);

} // namespace isosurface

#endif
