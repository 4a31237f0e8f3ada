// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceRanges_h
#define isosurface_SurfaceRanges_h

#include "Ground/Base/ParallelFor.h"
#include "Surface/Contour/Surface.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace isosurface
{

/// Points or cells of a surface that one thread treats at once.
constexpr std::size_t SurfaceRangeSize = std::size_t{ 1 } << 16;

constexpr std::size_t CountRanges(std::size_t items)
{
  return (items + SurfaceRangeSize - 1) / SurfaceRangeSize;
}

/// Calls body(begin, end, range) for all ranges of points or cells, on several threads.
template <typename Body>
void ForRanges(std::size_t items, int threads, const Body& body)
{
  ParallelFor(CountRanges(items), threads,
    [&](std::size_t range, int)
    {
      const std::size_t begin = range * SurfaceRangeSize;
      body(begin, std::min(items, begin + SurfaceRangeSize), range);
    });
}

/// Replaces the count of each range by the sum of the counts before it; the entry behind the last
/// range, which was 0, becomes the sum of all.
inline void SumRanges(std::vector<std::size_t>& counts)
{
  std::size_t sum = 0;
  for (std::size_t& count : counts)
  {
    sum += std::exchange(count, sum);
  }
}

/// The cells of a surface, whose indices have the type Index.
template <typename Index>
class SurfaceCells
{
public:
  explicit SurfaceCells(const Surface& surface)
    : Corners(GetValues(surface.Connectivity))
    , Offsets(surface.Connectivity.GetSize() == 3 * surface.NumberOfCells
          ? nullptr
          : GetValues(surface.Offsets))
  {
  }

  /// The places of the corners of a cell: from Begin up to, but not including, End.
  std::size_t Begin(std::size_t cell) const
  {
    return this->Offsets ? static_cast<std::size_t>(this->Offsets[cell]) : 3 * cell;
  }
  std::size_t End(std::size_t cell) const { return this->Begin(cell + 1); }
  /// The point at a corner.
  std::size_t operator[](std::size_t corner) const
  {
    return static_cast<std::size_t>(this->Corners[corner]);
  }
  std::size_t GetFirstPoint(std::size_t cell) const { return (*this)[this->Begin(cell)]; }

  /// Calls body(a, b, c) for the points of the triangles that a cell consists of.
  template <typename Body>
  void ForTriangles(std::size_t cell, const Body& body) const
  {
    const std::size_t begin = this->Begin(cell);
    const std::size_t end = this->End(cell);
    for (std::size_t last = begin + 2; last < end; ++last)
    {
      body((*this)[begin], (*this)[last - 1], (*this)[last]);
    }
  }

private:
  static const Index* GetValues(const IndexArray& indices)
  {
    if constexpr (sizeof(Index) == sizeof(std::int64_t))
    {
      return indices.Values64.GetData();
    }
    else
    {
      return indices.Values32.GetData();
    }
  }

  const Index* Corners;
  const Index* Offsets; ///< null if all cells are triangles
};

/// Calls body(cells) with the SurfaceCells of a surface.
template <typename Body>
void WithCells(const Surface& surface, const Body& body)
{
  if (surface.Connectivity.Is64Bit)
  {
    body(SurfaceCells<std::int64_t>(surface));
  }
  else
  {
    body(SurfaceCells<std::int32_t>(surface));
  }
}

} // namespace isosurface

#endif
