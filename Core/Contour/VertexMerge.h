// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VertexMerge_h
#define isosurface_VertexMerge_h

#include "Base/Buffer.h"
#include "Base/Progress.h"
#include "Contour/BrickLattice.h"
#include "Contour/BrickScan.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Decides, between the two phases of an extraction, which points become one because they lie on one
 * vertex of the grid, which triangles have three different corners left, and how the points of
 * these are numbered: in their old order, the first of a vertex standing for all.
 *
 * Cost: the triangles are made once more, and not kept; 9 bytes of memory a point, one hash table
 * entry for each vertex with points on the face of a brick.
 */
class VertexMerge
{
public:
  /// The parts of `scan` must know their FirstPoint.
  VertexMerge(const BrickLattice& lattice, BrickScan& scan);

  /// Returns false if `progress` asked to stop. Sets Kept of every part.
  bool Run(int threads, const Progress& progress);

  /// The new number of a point by its old one; -1 if it is left out.
  std::int64_t GetNumber(std::int64_t point) const
  {
    return this->Numbers[static_cast<std::size_t>(point)];
  }

  /// The triangles of a part of the scan, three old numbers each; `corners` holds them until the
  /// next call with it.
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
  /// By old number: at first the old number of the point that stands for it, then the new one.
  Buffer<std::int64_t> Numbers;
  std::vector<std::atomic<std::uint8_t>> AreUsed; ///< by old number
};

} // namespace isosurface

#endif
