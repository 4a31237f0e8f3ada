// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/VertexPoints.h"

#include <cmath>
#include <cstddef>

namespace isosurface
{

std::uint32_t FindVertexPoints(const BrickSamples& position, EdgeCode* codes, float* coordinates,
  double* parameters, bool areDouble, std::uint32_t count, VertexPoint* points)
{
  double at[3][MaximumBrickSize + 1];
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int n = 0; n <= position.Size[axis]; ++n)
    {
      const double exact =
        static_cast<double>(position.Low[axis] + n) + static_cast<double>(position.ExtentLow[axis]);
      at[axis][n] = areDouble ? exact : static_cast<double>(static_cast<float>(exact));
    }
  }
  VertexPoint* next = points;
  for (std::uint32_t n = 0; n < count; ++n)
  {
    const EdgeCode axis = codes[n] >> 18;
    const EdgeCode from = codes[n] >> (6 * axis) & 63;
    const double place =
      areDouble ? at[axis][from] + parameters[n] : static_cast<double>(coordinates[n]);
    const bool atLow = place == at[axis][from];
    if (!atLow && place != at[axis][from + 1])
    {
      continue;
    }
    const EdgeCode ends = codes[n] & ((EdgeCode(1) << 18) - 1);
    const EdgeCode vertex = atLow ? ends : ends + (EdgeCode(1) << (6 * axis));
    next->Point = n;
    next->I = static_cast<std::uint16_t>(vertex & 63);
    next->J = static_cast<std::uint8_t>(vertex >> 6 & 63);
    next->K = static_cast<std::uint8_t>(vertex >> 12 & 63);
    next->IsMerged = false;
    codes[n] = vertex | VertexAxis << 18;
    coordinates[n] = static_cast<float>(at[0][next->I]);
    if (parameters)
    {
      parameters[n] = 0;
    }
    ++next;
  }
  return static_cast<std::uint32_t>(next - points);
}

void SetNormalsOnSides(const GridSides& closedSides, const Index3& dimensions, const Index3& low,
  const VertexPoint* points, std::uint32_t count, float* normals)
{
  for (std::uint32_t n = 0; n < count; ++n)
  {
    const VertexPoint& point = points[n];
    const Index3 vertex{ low[0] + point.I, low[1] + point.J, low[2] + point.K };
    float outward[3];
    float square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      outward[axis] =
        static_cast<float>(closedSides.HasHigh(axis) && vertex[axis] == dimensions[axis] - 1) -
        static_cast<float>(closedSides.HasLow(axis) && vertex[axis] == 0);
      square += outward[axis] * outward[axis];
    }
    if (square > 0)
    {
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        normals[3 * static_cast<std::size_t>(point.Point) + axis] =
          outward[axis] / std::sqrt(square);
      }
    }
  }
}

} // namespace isosurface
