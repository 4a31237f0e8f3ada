// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TriangleSet_h
#define isosurface_TriangleSet_h

#include "Fixtures/PlainContour.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <utility>
#include <vector>

namespace isosurface
{

/// Triangles by the positions of their corners, independent of point numbers: each begins with its
/// minimum corner, and they are sorted.
using Place = std::array<float, 3>;
using TriangleSet = std::vector<std::array<Place, 3>>;

inline void AddTriangle(TriangleSet& set, std::array<Place, 3> corners)
{
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  set.push_back(corners);
}

inline TriangleSet MakeTriangleSet(const PlainSurface& surface)
{
  TriangleSet set;
  for (const auto& triangle : surface.Triangles)
  {
    std::array<Place, 3> corners;
    for (std::size_t n = 0; n < 3; ++n)
    {
      std::memcpy(corners[n].data(), surface.Points.at(triangle[n]).data(), sizeof(Place));
    }
    AddTriangle(set, corners);
  }
  std::sort(set.begin(), set.end());
  return set;
}

/// The triangles that have three different corners.
inline TriangleSet DropDegenerate(const TriangleSet& set)
{
  TriangleSet kept;
  std::copy_if(set.begin(), set.end(), std::back_inserter(kept),
    [](const auto& t) { return t[0] != t[1] && t[1] != t[2] && t[2] != t[0]; });
  return kept;
}

/// Moves the corners into the box of the grid's structured coordinates, and sorts again.
inline TriangleSet Clamp(const TriangleSet& set, const GridGeometry& grid)
{
  TriangleSet clamped;
  for (auto triangle : set)
  {
    for (Place& place : triangle)
    {
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        place[axis] = std::min(std::max(place[axis], static_cast<float>(grid.Extent[2 * axis])),
          static_cast<float>(grid.Extent[2 * axis + 1]));
      }
    }
    AddTriangle(clamped, triangle);
  }
  std::sort(clamped.begin(), clamped.end());
  return clamped;
}

/// For each side of a triangle, how often it occurs minus how often its reverse occurs.
inline bool IsClosed(const PlainSurface& surface)
{
  std::map<std::pair<std::int64_t, std::int64_t>, int> sides;
  for (const auto& triangle : surface.Triangles)
  {
    for (std::size_t n = 0; n < 3; ++n)
    {
      const std::int64_t from = triangle[n];
      const std::int64_t to = triangle[(n + 1) % 3];
      sides[std::minmax(from, to)] += from < to ? 1 : -1;
    }
  }
  return std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 0; });
}

/// Whether each side belongs to exactly two triangles.
inline bool IsManifold(const PlainSurface& surface)
{
  std::map<std::pair<std::int64_t, std::int64_t>, int> sides;
  for (const auto& triangle : surface.Triangles)
  {
    for (std::size_t n = 0; n < 3; ++n)
    {
      ++sides[std::minmax(triangle[n], triangle[(n + 1) % 3])];
    }
  }
  return IsClosed(surface) &&
    std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 2; });
}

/// Six times the volume that a closed surface with outward orientation encloses.
inline double ComputeSixfoldVolume(const TriangleSet& set)
{
  double volume = 0;
  for (const auto& [a, b, c] : set)
  {
    volume += double(a[0]) * (double(b[1]) * c[2] - double(b[2]) * c[1]) +
      double(a[1]) * (double(b[2]) * c[0] - double(b[0]) * c[2]) +
      double(a[2]) * (double(b[0]) * c[1] - double(b[1]) * c[0]);
  }
  return volume;
}

} // namespace isosurface

#endif
