// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SightedBox_h
#define isosurface_SightedBox_h

#include "Ground/Volume/Region.h"
#include "Ground/Volume/Sight.h"
#include "Ground/Volume/VertexBox.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <cstdint>

namespace isosurface
{

/// A part of a volume that is shown exactly in place of a sample's. Both boxes have the same faces in the world.
struct SightedBox
{
  VertexBox Exact;   ///< vertices of the volume; empty: no part
  VertexBox Sampled; ///< those of the sample; empty if the sample has no cell there

  bool operator==(const SightedBox& other) const
  {
    return this->Exact == other.Exact && this->Sampled == other.Sampled;
  }
};

/**
 * The box around the point at a distance on a line of sight, as wide as what is seen there: whole chunks of the
 * volume's source, of at most `vertices`, or else a smaller one around that point. Its faces are moved inwards to those
 * of cells of the sample, which is of the same grid. `region`: what lies beyond its sides along axes of the world is
 * left out.
 */
SightedBox FindSightedBox(const BlockedVolumeHeader& volume, const Sight& sight, double distance,
  const Region& region, std::int64_t vertices, const GridGeometry& sample,
  const GridLines* sampleLines);

} // namespace isosurface

#endif
