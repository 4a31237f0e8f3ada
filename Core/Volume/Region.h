// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Region_h
#define isosurface_Region_h

#include "Volume/BlockGrid.h"
#include "Volume/GridGeometry.h"

#include <array>
#include <vector>

namespace isosurface
{

/// All points x of the world with Normal . x <= Offset.
struct HalfSpace
{
  std::array<double, 3> Normal{};
  double Offset = 0;

  bool operator==(const HalfSpace& other) const
  {
    return this->Normal == other.Normal && this->Offset == other.Offset;
  }
};

/**
 * A convex part of the world: what lies in all of its half-spaces. Without any it is everything.
 */
class Region
{
public:
  Region() = default;
  explicit Region(std::vector<HalfSpace> halfSpaces);

  /// A box: x0, x1, y0, y1, z0, z1, borders included; nothing if one begins behind its end.
  static Region FromBounds(const std::array<double, 6>& bounds);

  const std::vector<HalfSpace>& GetHalfSpaces() const { return this->HalfSpaces; }
  bool IsEverything() const { return this->HalfSpaces.empty(); }

  /// Whether both have the same half-spaces, in the same order.
  bool operator==(const Region& other) const { return this->HalfSpaces == other.HalfSpaces; }

  /// What lies in both regions.
  Region Intersect(const Region& other) const;

  /**
   * Whether some point of the box between these vertices of the grid lies in the region. Exact, for
   * grids of any direction, but for rounding, which counts as inside.
   *
   * The half-spaces that cut the box, and the box, bound a convex body, which has a corner unless
   * it is empty: all corners that there might be are tried. Cost: that of 3 x 3 equations, one for
   * every three of the planes; none for boxes that lie on one side of all but one plane.
   */
  bool Intersects(const GridGeometry& grid, const VertexBox& vertices) const;

private:
  std::vector<HalfSpace> HalfSpaces;
};

} // namespace isosurface

#endif
