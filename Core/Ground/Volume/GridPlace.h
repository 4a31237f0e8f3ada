// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GridPlace_h
#define isosurface_GridPlace_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/GridGeometry.h"

#include <array>
#include <optional>
#include <string>

namespace isosurface
{

/// A user's spacing, origin and unit of a grid; members without a value are those of the file.
struct GridPlace
{
  std::optional<std::array<double, 3>> Spacing = {}; ///< distances; the file's directions stay
  std::optional<std::array<double, 3>> Origin = {};  ///< of the vertex with coordinates (0, 0, 0)
  std::optional<LengthUnit> Unit = {};

  bool operator==(const GridPlace& other) const
  {
    return this->Spacing == other.Spacing && this->Origin == other.Origin &&
      this->Unit == other.Unit;
  }

  /// Ok if distances are above 0, and all numbers finite. Errors name the file.
  Status Check(const std::string& path) const;
  /// Changes the grid of a file. Errors: those of Check(), and a spacing or an origin of a rectilinear grid,
  /// which its coordinates place.
  Status Apply(const std::string& path, bool isRectilinear, GridGeometry& grid) const;
};

/// How many times as large a surface and a body are if their grid is changed. Area: 0 if that depends on
/// where the surface faces.
struct GridScale
{
  double Area = 1;
  double Volume = 1;

  static GridScale Find(const GridGeometry& from, const GridGeometry& to);
};

} // namespace isosurface

#endif
