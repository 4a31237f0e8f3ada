// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceRanges_h
#define isosurface_SurfaceRanges_h

#include "Ground/Base/ParallelFor.h"
#include "Surface/Contour/Surface.h"

#include <algorithm>
#include <cstddef>

namespace isosurface
{

/// Points or cells of a surface that one thread treats at once; a multiple of 64.
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

/// The first corner of a cell in Surface::Connectivity, and the one behind its last.
struct CellCorners
{
  std::size_t Begin;
  std::size_t End;

  CellCorners(const Surface& surface, std::size_t cell)
    : Begin(
        surface.Offsets.GetSize() == 0 ? 3 * cell : static_cast<std::size_t>(surface.Offsets[cell]))
    , End(surface.Offsets.GetSize() == 0 ? Begin + 3
                                         : static_cast<std::size_t>(surface.Offsets[cell + 1]))
  {
  }
};

} // namespace isosurface

#endif
