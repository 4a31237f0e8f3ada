// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SharedPoints_h
#define isosurface_SharedPoints_h

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Coding/Meshes/MeshFile.h"
#include "Ground/Volume/VertexBox.h"

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace isosurface
{

/// A part of a surface that is decoded at once: the blocks with cells in a box.
struct SurfacePortion
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
std::vector<SurfacePortion> CutSurface(const EdgeIndexFile& file, std::uint64_t points);

/**
 * Numbers the points of a surface that comes in pieces (CutSurface), each point once. Of the points
 * that were numbered it keeps only those in the plane at the end of a layer and at the end of a piece.
 */
class SharedPoints
{
public:
  /// `dimensions`: vertices of the grid. `closed`: isovalues of a closed surface, whose ids count a layer around
  /// the grid, too, and after all edges vertices; 0 of an open one.
  explicit SharedPoints(const Index3& dimensions, std::size_t closed = 0)
    : Dimensions(dimensions)
    , Closed(static_cast<std::int64_t>(closed))
  {
  }

  std::uint64_t GetNumberOfPoints() const { return this->NumberOfPoints; }

  /// To be called for every piece, in their order, even if nothing of it is kept.
  void Begin(const SurfacePortion& piece);

  /// Of a mesh of the piece that was begun.
  PointNumbers Number(const Mesh& mesh);

private:
  using Numbers = std::unordered_map<std::int64_t, std::uint64_t>;

  Index3 Dimensions;
  std::int64_t Closed;
  std::uint64_t NumberOfPoints = 0;
  VertexBox Box; ///< of the piece
  Numbers Layer; ///< points at the end of the layer before
  Numbers NextLayer;
  Numbers Row; ///< points at the end of the piece before, in this layer
  Numbers NextRow;
};

} // namespace isosurface

#endif
