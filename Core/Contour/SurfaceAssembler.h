// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceAssembler_h
#define isosurface_SurfaceAssembler_h

#include "Base/Progress.h"
#include "Contour/BrickLattice.h"
#include "Contour/BrickScan.h"
#include "Contour/SurfaceExtractor.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/**
 * The second phase of an extraction: puts the bricks' points in their final place and writes the
 * cells, without looking at samples again. Edges on shared faces are looked up in the rows of the
 * brick that owns them.
 */
class SurfaceAssembler
{
public:
  SurfaceAssembler(const GridGeometry& geometry, const BrickLattice& lattice, BrickScan& scan,
    const ContourRequest& request);

  /// Counts, allocates and fills the surface's arrays. Returns false if `progress` asked to stop.
  bool Run(int threads, const Progress& progress, Surface& surface);

private:
  /// Sets where each part begins, and the surface's counts.
  void Count(Surface& surface);
  void Allocate(Surface& surface) const;
  void WriteBrick(std::size_t isovalue, std::size_t brick, Surface& surface) const;
  void WriteAttributes(const BrickPart& part, Surface& surface) const;
  template <typename Id>
  void WriteCells(std::size_t isovalue, std::size_t brick, Id* connectivity, Id* offsets) const;

  const GridGeometry& Geometry;
  const BrickLattice& Lattice;
  BrickScan& Scan;
  const ContourRequest& Request;
  WorldTransform Transform;
};

} // namespace isosurface

#endif
