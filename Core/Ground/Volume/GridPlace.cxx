// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/GridPlace.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <sstream>

namespace isosurface
{
namespace
{

Status MakePlaceError(
  const std::string& path, const char* name, const std::array<double, 3>& numbers, const char* rule)
{
  std::ostringstream text;
  text << path << ": " << name << " is set to " << numbers[0] << ", " << numbers[1] << ", "
       << numbers[2] << ": " << rule;
  return Status(StatusCode::InvalidArgument, text.str());
}

bool AreFinite(const std::array<double, 3>& numbers)
{
  return std::all_of(
    numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
}

} // namespace

Status GridPlace::Check(const std::string& path) const
{
  if (this->Spacing &&
    !(AreFinite(*this->Spacing) &&
      *std::min_element(this->Spacing->begin(), this->Spacing->end()) > 0))
  {
    return MakePlaceError(path, "Spacing", *this->Spacing, "distances are finite and above 0");
  }
  if (this->Origin && !AreFinite(*this->Origin))
  {
    return MakePlaceError(path, "Origin", *this->Origin, "coordinates are finite");
  }
  return Status::Ok();
}

Status GridPlace::Apply(const std::string& path, bool isRectilinear, GridGeometry& grid) const
{
  ISOSURFACE_RETURN_IF_ERROR(this->Check(path));
  if (isRectilinear && (this->Spacing || this->Origin))
  {
    return Status(StatusCode::InvalidArgument,
      path + ": " + (this->Spacing ? "Spacing" : "Origin") +
        " cannot be set: the grid is rectilinear, and the coordinates in the file place it");
  }
  for (std::size_t axis = 0; this->Spacing && axis < 3; ++axis)
  {
    grid.Spacing[axis] = std::copysign((*this->Spacing)[axis], grid.Spacing[axis]);
  }
  grid.Origin = this->Origin.value_or(grid.Origin);
  grid.Unit = this->Unit.value_or(grid.Unit);
  return Status::Ok();
}

GridScale GridScale::Find(const GridGeometry& from, const GridGeometry& to)
{
  std::array<double, 3> ratios;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    ratios[axis] = std::abs(to.Spacing[axis] / from.Spacing[axis]);
  }
  const auto [low, high] = std::minmax_element(ratios.begin(), ratios.end());
  constexpr double rounding = 1e-9;
  return { *high - *low <= rounding * *high ? ratios[0] * ratios[0] : 0,
    ratios[0] * ratios[1] * ratios[2] };
}

} // namespace isosurface
