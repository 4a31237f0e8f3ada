// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceAssembler_h
#define isosurface_SurfaceAssembler_h

#include "Ground/Base/Progress.h"
#include "Surface/Contour/BrickLattice.h"
#include "Surface/Contour/BrickScan.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Contour/VertexMerge.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/**
 * The second phase of an extraction: writes the points of all bricks to their final place, then the
 * cells. Does not use the samples. The points of shared edges are found in the rows of the brick
 * that owns them.
 */
class SurfaceAssembler
{
public:
  SurfaceAssembler(const GridGeometry& geometry, const BrickLattice& lattice, BrickScan& scan,
    const ContourRequest& request);

  /// Counts, allocates and fills the surface's arrays. Returns false if `progress` asked to stop.
  bool Run(int threads, const Progress& progress, Surface& surface);

private:
  using Corners = std::vector<std::int64_t>;

  /// Numbers the points of all parts. All are kept at first.
  void NumberPoints();
  /// Sets the place of each part in the surface, and the surface's counts.
  void Count(Surface& surface);
  void Allocate(Surface& surface) const;
  void WriteBrick(std::size_t part, Surface& surface, Corners& corners) const;
  void WritePoints(std::size_t part, Surface& surface) const;
  void WriteAttributes(const BrickSurface& part, Surface& surface) const;
  void DropPoints(const BrickSurface& part) const;
  template <typename Id>
  void WriteCells(std::size_t number, Id* connectivity, Id* offsets, Corners& corners) const;
  template <typename Id>
  void WriteKeptTriangles(std::size_t number, Id* connectivity, Corners& corners) const;

  /// The grid whose vertices the global ids count, and the coordinate of the blocks' first vertex
  /// in it (the same on all axes).
  GridGeometry NumberedGrid;
  std::int64_t FirstVertex;
  const BrickLattice& Lattice;
  BrickScan& Scan;
  const ContourRequest& Request;
  WorldTransform Transform;
  std::unique_ptr<VertexMerge> Merge; ///< null if all triangles are kept
};

} // namespace isosurface

#endif
