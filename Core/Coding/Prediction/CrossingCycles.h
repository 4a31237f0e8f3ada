// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CrossingCycles_h
#define isosurface_CrossingCycles_h

#include "Coding/EntropyCoding/AdaptiveModels.h"
#include "Coding/Prediction/CrossingFit.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Predicts the crossing of an edge from cycles: 3 or 5 decoded crossed edges that lead around a face
 * or a corner of a cell from one end of the edge to the other. A crossing at t gives the ratio of the
 * values at the ends of its edge, (t - 1) / t. So a cycle gives that ratio for the predicted edge,
 * and its crossing up to the error of the decoded positions.
 */
class CrossingCycles
{
public:
  /// The variance of positions within an interval; variances are in units of 2^-8 of it.
  static constexpr std::int32_t VarianceUnit = 256;

  struct Result
  {
    std::int32_t Position = 0; ///< in units of 1 / CrossingFit::FineUnit
    std::int64_t Weight = 0;   ///< 2^24 / variance; 0 if there is no cycle
  };

  /// The table for all blocks, made by the first call.
  static const CrossingCycles& Get();

  /// at: the index of the edge's first vertex (x, y) in a plane.
  Result Predict(int axis, int x, int y, std::ptrdiff_t at, const CrossingPlanes& planes) const;

private:
  struct Step
  {
    std::size_t Plane = 0;
    std::size_t Axis = 0;
    int X = 0; ///< of its first vertex, relative to that of the predicted edge
    int Y = 0;
    bool Forward = true; ///< from the first vertex to the second
  };
  using Path = std::vector<Step>;

  CrossingCycles();
  // vertices: from the first to the second vertex of the predicted edge, relative to the first.
  void AddPath(int axis, const std::vector<std::array<int, 3>>& vertices);

  // t (1 - t), in units of 2^-10.
  static std::int32_t FindSpread(std::int32_t position)
  {
    return position * (CrossingFit::Unit - position) >> 10;
  }

  std::array<std::vector<Path>, 3> Paths;
  std::array<std::int32_t, CrossingFit::Unit / 4 + 1>
    Variances; ///< by t (1 - t): 2^24 / its square
};

inline CrossingCycles::Result CrossingCycles::Predict(
  int axis, int x, int y, std::ptrdiff_t at, const CrossingPlanes& planes) const
{
  std::int64_t sum = 0;
  std::int64_t weights = 0;
  for (const Path& path : this->Paths[static_cast<std::size_t>(axis)])
  {
    int logarithm = 0;
    std::int64_t variance = 0;
    bool whole = true;
    for (const Step& step : path)
    {
      const CrossingPlane& plane = (*planes[step.Plane])[step.Axis];
      const std::int16_t position =
        plane.Positions[static_cast<std::size_t>(at + step.Y * CrossingFit::RowStride + step.X)];
      whole =
        plane.Crossed[static_cast<std::size_t>(y + step.Y + 2)].Get(x + step.X) && position >= 0;
      if (!whole)
      {
        break;
      }
      const int stretched = Tables.Stretch[static_cast<std::size_t>(4 * position + 2)];
      logarithm += step.Forward ? stretched : -stretched;
      variance += this->Variances[static_cast<std::size_t>(FindSpread(position))];
    }
    if (!whole)
    {
      continue;
    }
    const auto crossing = static_cast<std::int32_t>(
      Tables.Squash[static_cast<std::size_t>(std::clamp(logarithm, -2047, 2047) + 2048)]);
    const std::int64_t spread = FindSpread(crossing >> 6);
    constexpr std::int64_t minimum = 3 * VarianceUnit / 5;
    const std::int64_t weight =
      (std::int64_t{ 1 } << 24) / ((variance * spread * spread >> 16) + minimum);
    sum += weight * crossing;
    weights += weight;
  }
  Result result;
  result.Weight = weights;
  result.Position = weights == 0 ? 0 : static_cast<std::int32_t>(sum / weights);
  return result;
}

} // namespace isosurface

#endif
