// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PointSampling_h
#define isosurface_PointSampling_h

#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/CutToRange.h"
#include "Storage/Sampling/LevelSamples.h"
#include "Storage/Store/QueryStatistics.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <type_traits>
#include <vector>

namespace isosurface
{

/// How a value between vertices is made of the samples around it.
enum class Interpolation
{
  Nearest, ///< the sample of the nearest vertex; of two, the one with the higher coordinate
  Linear   ///< trilinear, as vtkVoxel interpolates; integers are rounded, halves away from 0
};

/// A point to sample: its vertex coordinates at the level (VertexPlaces), and the number of its
/// value in the result.
struct SamplePoint
{
  std::array<double, 3> Vertex{};
  std::int64_t Number = 0;
};

/// Many points, a portion at a time. A portion has at most a few thousand points that are close to
/// each other, since its blocks are held together.
struct PointPortions
{
  std::size_t Count = 0;
  /// Fills in the points of a portion; called by several threads at once.
  std::function<void(std::size_t portion, std::vector<SamplePoint>& points)> Give;
};

/**
 * Fills `values` with one variable at points, and `isInside` with 1 for each point within the grid,
 * else with 0; the values of points beyond it are left as they were. `isInside` may be null. Points
 * beyond the grid by less than a millionth of a cell count as inside. Values have the variable's
 * type; successive ones are `stride` apart.
 *
 * A vertex of weight 0 has no part in a value: at a vertex the value is its sample, whatever is
 * around it.
 *
 * Reads each block that has a cell with a point, through the block cache, on `threads` threads; a
 * block once for each portion that it belongs to, if the cache cannot keep it. Errors: of
 * BlockedVolume::ReadBlock; Aborted.
 */
Status SamplePoints(const LevelSamples& samples, std::size_t variable, Interpolation interpolation,
  const PointPortions& points, int threads, void* values, std::ptrdiff_t stride,
  std::uint8_t* isInside, QueryStatistics& statistics, const Progress& progress = {});

/// The same of some arrays at points of the world, whose places `find` gives to several threads at once. `values` has
/// the tuples of each of the arrays.
Status SampleArrays(const LevelSamples& samples, const std::vector<std::size_t>& arrays,
  Interpolation interpolation, std::int64_t count,
  const std::function<std::array<double, 3>(std::int64_t point)>& find, int threads,
  const std::vector<void*>& values, std::uint8_t* isInside, const Progress& progress);

/// The value that Interpolation::Linear stores: integers are rounded.
template <typename Value>
Value RoundInterpolated(double value)
{
  if constexpr (std::is_integral_v<Value>)
  {
    // Only between samples of 64 bits is a number beyond the samples: the maximum is no double.
    const double rounded = std::round(value);
    return sizeof(Value) == 8 ? CutToRange<Value>(rounded) : static_cast<Value>(rounded);
  }
  else
  {
    return static_cast<Value>(value);
  }
}

} // namespace isosurface

#endif
