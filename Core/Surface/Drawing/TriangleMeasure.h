// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TriangleMeasure_h
#define isosurface_TriangleMeasure_h

#include "Surface/Drawing/TriangleSurface.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// What drawing has to know of a surface.
struct TriangleMeasure
{
  /// Triangles are counted, copied and left out of an image in runs of TrianglesOfRun. The
  /// triangles of an isosurface come block by block, so those of a run are close to each other.
  static constexpr std::size_t TrianglesOfRun = std::size_t{ 1 } << 9;

  bool IsValid = false; ///< whether every point number is one of the surface's points
  /// Of the points that triangles use: xmin, xmax, ymin ...; minimum > maximum if there are none.
  std::array<double, 6> Bounds = { 1, -1, 1, -1, 1, -1 };
  /// Of all points, whether triangles use them or not.
  std::array<double, 6> PointBounds = { 1, -1, 1, -1, 1, -1 };
  /// By run: how many triangles have three points in different places.
  std::vector<std::uint32_t> ProperTriangles;
  /// By run, as Bounds.
  std::vector<std::array<float, 6>> RunBounds;
};

/**
 * Measures a surface: its bounds, and its triangles that are not degenerate. Points that no
 * triangle uses do not count for the bounds. Each triangle and each point is visited once, by
 * `threads` threads.
 */
TriangleMeasure MeasureTriangles(const TriangleSurface& surface, int threads);

/// Whether `offsets` are those of `cells` triangles: 0, 3, 6 ..., one more than there are cells.
bool AreTriangleOffsets(const std::int32_t* offsets, std::size_t cells, int threads);
bool AreTriangleOffsets(const std::int64_t* offsets, std::size_t cells, int threads);

} // namespace isosurface

#endif
