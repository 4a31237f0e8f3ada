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
      const std::int64_t from = triangle[n];
      const std::int64_t to = triangle[(n + 1) % 3];
      ++sides[std::minmax(from, to)];
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

/// The union of the surfaces of several ranks. Checks that points with equal ids are equal.
inline PlainSurface UniteRanks(const std::vector<PlainSurface>& ranks, bool& agree)
{
  PlainSurface united;
  for (const PlainSurface& rank : ranks)
  {
    united.Triangles.insert(united.Triangles.end(), rank.Triangles.begin(), rank.Triangles.end());
    for (const auto& [id, bits] : rank.Points)
    {
      agree = agree && united.Points.emplace(id, bits).first->second == bits;
    }
  }
  std::sort(united.Triangles.begin(), united.Triangles.end());
  return united;
}

/// The blocks of a source that a selection needs, by brute force over all samples.
template <typename T>
std::vector<std::int64_t> FindBlocksByForce(
  const SampleVolume<T>& volume, int blockSize, const std::vector<double>& isovalues, bool closed)
{
  const BlockGrid grid(volume.GetDimensions(), blockSize);
  const Index3 size = volume.GetDimensions();
  std::vector<std::int64_t> blocks;
  for (std::int64_t block = 0; block < grid.GetNumberOfBlocks(); ++block)
  {
    const VertexBox box = grid.GetVertices(block);
    bool isWanted = false;
    for (const double isovalue : isovalues)
    {
      bool anyInside = false;
      bool anyOutside = false;
      for (std::int64_t k = box.Low[2]; k < box.High[2]; ++k)
      {
        for (std::int64_t j = box.Low[1]; j < box.High[1]; ++j)
        {
          for (std::int64_t i = box.Low[0]; i < box.High[0]; ++i)
          {
            const bool inside = static_cast<double>(volume.At(i, j, k)) >= isovalue;
            anyInside = anyInside || inside;
            anyOutside = anyOutside || !inside;
          }
        }
      }
      const bool atBorder = box.Low[0] == 0 || box.Low[1] == 0 || box.Low[2] == 0 ||
        box.High[0] == size[0] || box.High[1] == size[1] || box.High[2] == size[2];
      isWanted = isWanted || (anyInside && (anyOutside || (closed && atBorder)));
    }
    if (isWanted)
    {
      blocks.push_back(block);
    }
  }
  return blocks;
}

} // namespace isosurface

#endif
