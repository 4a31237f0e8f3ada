// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Prediction/CrossingCycles.h"

namespace isosurface
{

const CrossingCycles& CrossingCycles::Get()
{
  static const CrossingCycles cycles;
  return cycles;
}

CrossingCycles::CrossingCycles()
{
  // Edges along x: over the face to the row before, over the face to the slice before, and both ways
  // around the cell between these faces.
  this->AddPath(0, { { 0, 0, 0 }, { 0, -1, 0 }, { 1, -1, 0 }, { 1, 0, 0 } });
  this->AddPath(0, { { 0, 0, 0 }, { 0, 0, -1 }, { 1, 0, -1 }, { 1, 0, 0 } });
  this->AddPath(
    0, { { 0, 0, 0 }, { 0, -1, 0 }, { 0, -1, -1 }, { 1, -1, -1 }, { 1, 0, -1 }, { 1, 0, 0 } });
  this->AddPath(
    0, { { 0, 0, 0 }, { 0, 0, -1 }, { 0, -1, -1 }, { 1, -1, -1 }, { 1, -1, 0 }, { 1, 0, 0 } });
  // Edges along y: over the face to the slice before, and around the cells on either side of it.
  this->AddPath(1, { { 0, 0, 0 }, { 0, 0, -1 }, { 0, 1, -1 }, { 0, 1, 0 } });
  for (const int side : { -1, 1 })
  {
    this->AddPath(1,
      { { 0, 0, 0 }, { side, 0, 0 }, { side, 0, -1 }, { side, 1, -1 }, { 0, 1, -1 }, { 0, 1, 0 } });
  }
  // Edges along z are decoded before all edges that begin at their second vertex: no cycles.
  constexpr std::int32_t minimumSpread = 20;
  for (std::size_t n = 0; n < this->Variances.size(); ++n)
  {
    const std::int32_t spread = std::max(static_cast<std::int32_t>(n), minimumSpread);
    this->Variances[n] = (1 << 24) / (spread * spread);
  }
}

void CrossingCycles::AddPath(int axis, const std::vector<std::array<int, 3>>& vertices)
{
  Path path;
  for (std::size_t n = 0; n + 1 < vertices.size(); ++n)
  {
    const std::array<int, 3>& from = vertices[n];
    const std::array<int, 3>& to = vertices[n + 1];
    Step step;
    step.Forward = to > from;
    while (to[step.Axis] == from[step.Axis])
    {
      ++step.Axis;
    }
    const std::array<int, 3>& first = step.Forward ? from : to;
    step.X = first[0];
    step.Y = first[1];
    step.Plane = static_cast<std::size_t>(-first[2]);
    path.push_back(step);
  }
  this->Paths[static_cast<std::size_t>(axis)].push_back(path);
}

} // namespace isosurface
