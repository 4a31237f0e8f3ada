// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GridSides_h
#define isosurface_GridSides_h

#include "Ground/Volume/BlockGrid.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace isosurface
{

/// Some of the six sides of a grid.
struct GridSides
{
  std::array<bool, 6> Sides{}; ///< the low side of axis a at 2 * a, the high one at 2 * a + 1
  /// Whether space beyond these sides counts as inside, so that outside samples become a body: pores.
  bool AreBeyondInside = false;

  static GridSides All() { return { { true, true, true, true, true, true }, false }; }

  bool HasLow(std::size_t axis) const { return this->Sides[2 * axis]; }
  bool HasHigh(std::size_t axis) const { return this->Sides[2 * axis + 1]; }
  bool IsEmpty() const
  {
    return std::none_of(this->Sides.begin(), this->Sides.end(), [](bool side) { return side; });
  }

  bool operator==(const GridSides& other) const
  {
    return this->Sides == other.Sides && this->AreBeyondInside == other.AreBeyondInside;
  }

  /// Whether a box of vertices touches one of these sides. `dimensions` are those of the grid.
  bool Touch(const VertexBox& box, const Index3& dimensions) const
  {
    bool touch = false;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      touch = touch || (this->HasLow(axis) && box.Low[axis] <= 0) ||
        (this->HasHigh(axis) && box.High[axis] >= dimensions[axis]);
    }
    return touch;
  }
};

} // namespace isosurface

#endif
