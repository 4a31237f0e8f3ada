// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/VertexPlaces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace isosurface
{
namespace
{

using Point = std::array<double, 3>;

// The place of a coordinate among lines; beyond them, at the distance of the last two.
double FindAmong(const std::vector<double>& lines, double coordinate)
{
  if (lines.size() < 2)
  {
    return lines.empty() ? 0 : coordinate - lines.front();
  }
  const auto above = std::upper_bound(lines.begin() + 1, lines.end() - 1, coordinate);
  const double low = *(above - 1);
  return static_cast<double>(above - 1 - lines.begin()) + (coordinate - low) / (*above - low);
}

double FindOnLines(const std::vector<double>& lines, double vertex)
{
  if (lines.size() < 2)
  {
    return lines.empty() ? 0 : lines.front() + vertex;
  }
  const double last = static_cast<double>(lines.size() - 2);
  const auto low = static_cast<std::size_t>(std::clamp(std::floor(vertex), 0.0, last));
  return lines[low] + (vertex - static_cast<double>(low)) * (lines[low + 1] - lines[low]);
}

} // namespace

VertexPlaces::VertexPlaces(const GridGeometry& grid, const GridLines* lines)
  : Grid(grid)
{
  if (lines)
  {
    this->Lines = *lines;
    return;
  }
  std::array<double, 9> m{}; // Direction * Spacing
  for (std::size_t row = 0; row < 3; ++row)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      m[3 * row + axis] = grid.Direction[3 * row + axis] * grid.Spacing[axis];
    }
  }
  // By cofactors: exact where the matrix is diagonal with powers of two.
  const auto cofactor = [&](std::size_t row, std::size_t column)
  {
    const std::size_t r0 = (row + 1) % 3;
    const std::size_t r1 = (row + 2) % 3;
    const std::size_t c0 = (column + 1) % 3;
    const std::size_t c1 = (column + 2) % 3;
    return m[3 * r0 + c0] * m[3 * r1 + c1] - m[3 * r0 + c1] * m[3 * r1 + c0];
  };
  const double determinant = m[0] * cofactor(0, 0) + m[1] * cofactor(0, 1) + m[2] * cofactor(0, 2);
  for (std::size_t row = 0; row < 3; ++row)
  {
    for (std::size_t column = 0; column < 3; ++column)
    {
      this->ToVertex[3 * row + column] = cofactor(column, row) / determinant;
    }
  }
}

Point VertexPlaces::FindVertex(const Point& point) const
{
  Point vertex{};
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (this->Lines)
    {
      vertex[axis] = FindAmong(this->Lines->Coordinates[axis], point[axis]);
      continue;
    }
    for (std::size_t column = 0; column < 3; ++column)
    {
      vertex[axis] +=
        this->ToVertex[3 * axis + column] * (point[column] - this->Grid.Origin[column]);
    }
    vertex[axis] -= static_cast<double>(this->Grid.Extent[2 * axis]);
  }
  return vertex;
}

Point VertexPlaces::FindPoint(const Point& vertex) const
{
  Point point{};
  for (std::size_t row = 0; row < 3; ++row)
  {
    if (this->Lines)
    {
      point[row] = FindOnLines(this->Lines->Coordinates[row], vertex[row]);
      continue;
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      point[row] += (static_cast<double>(this->Grid.Extent[2 * axis]) + vertex[axis]) *
        (this->Grid.Direction[3 * row + axis] * this->Grid.Spacing[axis]);
    }
    point[row] += this->Grid.Origin[row];
  }
  return point;
}

VertexBox VertexPlaces::FindVerticesAround(const Point& corner, const Point& opposite) const
{
  Point low{};
  Point high{};
  for (unsigned number = 0; number < 8; ++number)
  {
    Point point{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      point[axis] = (number >> axis & 1U) != 0 ? opposite[axis] : corner[axis];
    }
    const Point vertex = this->FindVertex(point);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      low[axis] = number == 0 ? vertex[axis] : std::min(low[axis], vertex[axis]);
      high[axis] = number == 0 ? vertex[axis] : std::max(high[axis], vertex[axis]);
    }
  }
  const Index3 dimensions = this->Grid.GetDimensions();
  VertexBox box;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    constexpr double tolerance = 1e-6;
    const auto last = static_cast<double>(dimensions[axis] - 1);
    if (!(high[axis] >= -tolerance && low[axis] <= last + tolerance)) // also if one is NaN
    {
      return {};
    }
    box.Low[axis] =
      static_cast<std::int64_t>(std::clamp(std::floor(low[axis] + tolerance), 0.0, last));
    box.High[axis] =
      static_cast<std::int64_t>(std::clamp(std::ceil(high[axis] - tolerance), 0.0, last)) + 1;
  }
  return box;
}

} // namespace isosurface
