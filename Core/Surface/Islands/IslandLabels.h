// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IslandLabels_h
#define isosurface_IslandLabels_h

#include "Surface/Contour/Surface.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * The islands of one rank's surface: two points are on the same one if a path of triangles (or
 * polygons) with common points joins them. Islands are numbered from 0 by their first points, so
 * neither numbers nor islands depend on the number of threads.
 *
 * By union-find over the points, without locks: a parent has a lower number than its child, so the
 * root of an island is its first point, whichever thread came first (Anderson and Woll, Wait-free
 * parallel algorithms for the union-find problem, 1991).
 */
class IslandLabels
{
public:
  IslandLabels() = default;
  /// Memory: 4 bytes a point, or 8 if the surface has indices of 64 bits. Throws std::bad_alloc.
  IslandLabels(const Surface& surface, int threads);

  std::size_t GetNumberOfIslands() const { return this->NumberOfIslands; }
  /// The island of a point.
  std::size_t operator[](std::size_t point) const
  {
    return static_cast<std::size_t>(this->Is64Bit
        ? this->Labels64[point].load(std::memory_order_relaxed)
        : this->Labels32[point].load(std::memory_order_relaxed));
  }

private:
  template <typename Index>
  void Label(const Surface& surface, int threads, std::vector<std::atomic<Index>>& labels);

  bool Is64Bit = false;
  std::size_t NumberOfIslands = 0;
  std::vector<std::atomic<std::int32_t>> Labels32; ///< one of the two is used
  std::vector<std::atomic<std::int64_t>> Labels64;
};

} // namespace isosurface

#endif
