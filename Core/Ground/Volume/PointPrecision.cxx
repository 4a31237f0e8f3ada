// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/PointPrecision.h"

#include "Ground/Volume/VertexPlaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace isosurface
{
namespace
{

/// Places of float32 between neighbours with which points are fine.
constexpr double Places = 16;

/// The distance of the float32 numbers from a magnitude on.
double GetDistanceOfFloats(double magnitude)
{
  using Float = std::numeric_limits<float>;
  if (!(magnitude <= static_cast<double>(Float::max())))
  {
    return std::numeric_limits<double>::infinity();
  }
  int exponent = 0;
  std::frexp(magnitude, &exponent);
  return std::max(
    std::ldexp(1.0, exponent - Float::digits), static_cast<double>(Float::denorm_min()));
}

bool AreLinesTooNear(const GridLines& lines)
{
  for (const std::vector<double>& axis : lines.Coordinates)
  {
    for (std::size_t n = 1; n < axis.size(); ++n)
    {
      const double magnitude = std::max(std::abs(axis[n - 1]), std::abs(axis[n]));
      if (Places * GetDistanceOfFloats(magnitude) > std::abs(axis[n] - axis[n - 1]))
      {
        return true;
      }
    }
  }
  return false;
}

/// The largest magnitude of a coordinate of the grid's vertices.
double FindMagnitude(const GridGeometry& grid, std::size_t row)
{
  double low = grid.Origin[row];
  double high = low;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double step = grid.Direction[3 * row + axis] * grid.Spacing[axis];
    const double first = step * static_cast<double>(grid.Extent[2 * axis]);
    const double last = step * static_cast<double>(grid.Extent[2 * axis + 1]);
    low += std::min(first, last);
    high += std::max(first, last);
  }
  return std::max(std::abs(low), std::abs(high));
}

} // namespace

bool NeedsDoublePoints(const GridGeometry& grid, const GridLines* lines)
{
  if (lines)
  {
    return AreLinesTooNear(*lines);
  }
  GridGeometry turned;
  turned.Direction = grid.Direction;
  const VertexPlaces places(turned);
  std::array<double, 3> distances{}; // of floats, along the grid's axes
  for (std::size_t row = 0; row < 3; ++row)
  {
    std::array<double, 3> step{};
    step[row] = GetDistanceOfFloats(FindMagnitude(grid, row));
    const std::array<double, 3> along = places.FindVertex(step);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      distances[axis] += std::abs(along[axis]);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double structured = std::max(std::abs(static_cast<double>(grid.Extent[2 * axis])),
      std::abs(static_cast<double>(grid.Extent[2 * axis + 1])));
    // Infinite distances may have become NaN.
    if (!(Places * distances[axis] <= std::abs(grid.Spacing[axis])) ||
      Places * GetDistanceOfFloats(structured) > 1)
    {
      return true;
    }
  }
  return false;
}

} // namespace isosurface
