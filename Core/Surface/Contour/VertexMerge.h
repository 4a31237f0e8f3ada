// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VertexMerge_h
#define isosurface_VertexMerge_h

#include "Ground/Base/Buffer.h"
#include "Ground/Base/Progress.h"
#include "Surface/Contour/BrickLattice.h"
#include "Surface/Contour/BrickScan.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Merges points on the same vertex of the grid, if these were found, between the two phases of an
 * extraction: finds the triangles that keep three different corners, and numbers the points of these
 * triangles in their old order. The first point of a vertex stands for all. So points that only
 * hidden cells use are dropped, too.
 *
 * Cost: the triangles are made once more, but not kept. Memory: 9 bytes a point, and a hash table
 * entry for each vertex with points on a face of a brick.
 */
class VertexMerge
{
public:
  /// The FirstPoint of the parts must be set.
  VertexMerge(const BrickLattice& lattice, BrickScan& scan);

  /// Returns false if `progress` asked to stop. Sets Kept of every part.
  bool Run(int threads, const Progress& progress);

  /// The new number of a point by its old number; -1 if it is dropped.
  std::int64_t GetNumber(std::int64_t point) const
  {
    return this->Numbers[static_cast<std::size_t>(point)];
  }

  /// The triangles of a part, three old numbers each, in `corners`.
  const std::int64_t* MakeTriangles(std::size_t part, std::vector<std::int64_t>& corners) const;

private:
  using FirstPoints = std::vector<std::uint32_t>;

  void MergeWithinBrick(std::size_t part, FirstPoints& firstPoints);
  void MergeAcrossBricks();
  void CountKept(std::size_t part, std::vector<std::int64_t>& corners);
  void NumberPoints(std::size_t part, std::int64_t first);

  const BrickLattice& Lattice;
  BrickScan& Scan;
  std::vector<std::size_t> Active; ///< the parts that are not empty
  /// By old number: first the old number of the point that stands for it, later the new number.
  Buffer<std::int64_t> Numbers;
  std::vector<std::atomic<std::uint8_t>> AreUsed; ///< by old number
};

} // namespace isosurface

#endif
