// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/AxisUnits.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace isosurface
{
namespace
{

/// A length in another unit. Most factors, or what they divide by, are whole numbers, but for rounding.
double ConvertLength(double length, LengthUnit from, LengthUnit to)
{
  const double factor = GetMeters(from) / GetMeters(to);
  const double whole = std::round(std::max(factor, 1 / factor));
  const bool isWhole = std::abs(std::max(factor, 1 / factor) - whole) < 1e-9 * whole;
  return !isWhole ? length * factor : factor < 1 ? length / whole : length * whole;
}

} // namespace

void AddNote(std::string& told, const std::string& note)
{
  told += (told.empty() ? "" : "; ") + note;
}

void TakeLengthUnits(const std::array<std::string, 3>& names, GridGeometry& grid, std::string& told)
{
  std::array<LengthUnit, 3> units{};
  std::transform(names.begin(), names.end(), units.begin(), FindLengthUnit);
  if (std::count(units.begin(), units.end(), LengthUnit::Unknown) > 0)
  {
    std::string list;
    for (std::size_t axis = 0; axis < names.size(); ++axis)
    {
      if (!names[axis].empty())
      {
        list += std::string(list.empty() ? "" : ", ") + "xyz"[axis] + " " + names[axis];
      }
    }
    if (!list.empty())
    {
      AddNote(told, "units of the axes are not kept: " + list);
    }
    return;
  }
  grid.Unit = units[0];
  for (std::size_t axis = 1; axis < units.size(); ++axis)
  {
    grid.Spacing[axis] = ConvertLength(grid.Spacing[axis], units[axis], grid.Unit);
    grid.Origin[axis] = ConvertLength(grid.Origin[axis], units[axis], grid.Unit);
  }
}

} // namespace isosurface
