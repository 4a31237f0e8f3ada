// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Region_h
#define isosurface_Region_h

#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/GridGeometry.h"

#include <array>
#include <vector>

namespace isosurface
{

/// All points x in world coordinates with Normal . x <= Offset.
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
 * A convex region in world coordinates: the intersection of half-spaces. Without any, it is all of
 * space.
 */
class Region
{
public:
  Region() = default;
  explicit Region(std::vector<HalfSpace> halfSpaces);

  /// A box x0, x1, y0, y1, z0, z1, including its faces; empty if a minimum is above its maximum.
  static Region FromBounds(const std::array<double, 6>& bounds);

  const std::vector<HalfSpace>& GetHalfSpaces() const { return this->HalfSpaces; }
  bool IsEverything() const { return this->HalfSpaces.empty(); }

  /// Whether both have the same half-spaces, in the same order.
  bool operator==(const Region& other) const { return this->HalfSpaces == other.HalfSpaces; }

  /// The intersection of both regions.
  Region Intersect(const Region& other) const;

  /**
   * Whether the region contains a point of the box that these vertices of the grid span. Exact for
   * grids of any direction, except that points within the rounding error count as inside.
   *
   * Method: the box and the half-spaces that cut it bound a convex body. Unless it is empty, it has
   * a corner where three of the planes meet; all such points are tried. Cost: a system of 3 x 3
   * equations for every three planes; none if the box lies on one side of all planes but one.
   */
  bool Intersects(const GridGeometry& grid, const VertexBox& vertices) const;

private:
  std::vector<HalfSpace> HalfSpaces;
};

} // namespace isosurface

#endif
