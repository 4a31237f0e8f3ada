// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/BoundsProjection.h"

#include <cmath>
#include <cstddef>
#include <vector>

namespace isosurface
{
namespace
{

using ClipPoint = std::array<double, 4>;

// The corners of the box; bit 0, 1, 2 of the index chooses the end along x, y, z.
std::array<ClipPoint, 8> ProjectCorners(
  const std::array<double, 6>& bounds, const std::array<double, 16>& worldToClip)
{
  std::array<ClipPoint, 8> corners{};
  for (std::size_t corner = 0; corner < 8; ++corner)
  {
    const std::array<double, 4> world = { bounds[corner & 1], bounds[2 + ((corner >> 1) & 1)],
      bounds[4 + ((corner >> 2) & 1)], 1 };
    for (std::size_t row = 0; row < 4; ++row)
    {
      for (std::size_t column = 0; column < 4; ++column)
      {
        corners[corner][row] += worldToClip[4 * row + column] * world[column];
      }
    }
  }
  return corners;
}

double GetDistanceToNearPlane(const ClipPoint& point)
{
  return point[2] + point[3];
}

// The corners of the box in front of the near plane, and where the other edges cross that plane.
std::vector<ClipPoint> ClipAtNearPlane(const std::array<ClipPoint, 8>& corners)
{
  std::vector<ClipPoint> clipped;
  for (std::size_t corner = 0; corner < 8; ++corner)
  {
    const double distance = GetDistanceToNearPlane(corners[corner]);
    if (distance >= 0)
    {
      clipped.push_back(corners[corner]);
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const std::size_t other = corner ^ (std::size_t{ 1 } << axis);
      const double otherDistance = GetDistanceToNearPlane(corners[other]);
      if (distance < 0 && otherDistance > 0)
      {
        const double fraction = otherDistance / (otherDistance - distance);
        ClipPoint crossing{};
        for (std::size_t row = 0; row < 4; ++row)
        {
          crossing[row] =
            corners[other][row] + fraction * (corners[corner][row] - corners[other][row]);
        }
        clipped.push_back(crossing);
      }
    }
  }
  return clipped;
}

// Pixels from the low edge of a display of `length` pixels, kept in the range of int.
double ToPixels(double normalized, int length)
{
  return std::clamp((normalized + 1) * 0.5 * length, -1e9, 1e9);
}

} // namespace

ProjectedBounds ProjectBounds(const std::array<double, 6>& bounds,
  const std::array<double, 16>& worldToClip, const PixelRectangle& display, double margin)
{
  if (bounds[0] > bounds[1] || bounds[2] > bounds[3] || bounds[4] > bounds[5])
  {
    return {};
  }
  ProjectedBounds projected;
  projected.NearDepth = HUGE_VAL;
  projected.FarDepth = -HUGE_VAL;
  double left = HUGE_VAL;
  double right = -HUGE_VAL;
  double bottom = HUGE_VAL;
  double top = -HUGE_VAL;
  bool finite = true;
  const std::array<ClipPoint, 8> corners = ProjectCorners(bounds, worldToClip);
  for (const ClipPoint& corner : corners)
  {
    finite = finite && std::isfinite(corner[0] + corner[1] + corner[2] + corner[3]);
  }
  for (const ClipPoint& point : finite ? ClipAtNearPlane(corners) : std::vector<ClipPoint>())
  {
    finite = finite && point[3] > 0;
    left = std::min(left, ToPixels(point[0] / point[3], display.Width));
    right = std::max(right, ToPixels(point[0] / point[3], display.Width));
    bottom = std::min(bottom, ToPixels(point[1] / point[3], display.Height));
    top = std::max(top, ToPixels(point[1] / point[3], display.Height));
    projected.NearDepth = std::min(projected.NearDepth, point[2] / point[3]);
    projected.FarDepth = std::max(projected.FarDepth, point[2] / point[3]);
  }
  if (!finite)
  {
    return { display, -1.0, 1.0 };
  }
  if (left > right || projected.NearDepth > 1)
  {
    return {};
  }
  const PixelRectangle widened =
    PixelRectangle::FromEdges(display.X + static_cast<int>(std::floor(left - margin)),
      display.Y + static_cast<int>(std::floor(bottom - margin)),
      display.X + static_cast<int>(std::ceil(right + margin)),
      display.Y + static_cast<int>(std::ceil(top + margin)));
  projected.Pixels = widened.Intersect(display);
  return projected.Pixels.IsEmpty() ? ProjectedBounds() : projected;
}

} // namespace isosurface
