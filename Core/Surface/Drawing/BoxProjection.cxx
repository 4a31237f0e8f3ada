// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Drawing/BoxProjection.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace isosurface
{
namespace
{

constexpr double DepthMargin = 1e-5;
constexpr double PixelMargin = 1;
/// Of a clip coordinate, relative to the sum of the terms that shaders add to it in single precision.
constexpr double Rounding = 1e-6;
/// What a box may cover is told up to here on both sides of an image's origin.
constexpr double MostPixels = 1e6;

int ToPixel(double place)
{
  return static_cast<int>(std::clamp(place, -MostPixels, MostPixels));
}

} // namespace

BoxProjection::BoxProjection(const std::array<double, 16>& modelToClip, int width, int height,
  const std::array<double, 3>& origin)
  : Matrix(modelToClip)
  , Origin(origin)
  , Width(width)
  , Height(height)
{
  for (std::size_t row = 0; row < 4; ++row)
  {
    double* m = this->Matrix.data() + 4 * row;
    m[3] += m[0] * origin[0] + m[1] * origin[1] + m[2] * origin[2];
  }
}

ProjectedBox BoxProjection::Project(const std::array<float, 6>& bounds) const
{
  ProjectedBox box;
  if (!(bounds[0] <= bounds[1] && bounds[2] <= bounds[3] && bounds[4] <= bounds[5]))
  {
    return box;
  }
  std::array<int, 6> beyond{}; // corners outside of each plane
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low{ infinity, infinity, infinity };
  std::array<double, 3> high{ -infinity, -infinity, -infinity };
  bool isKnown = true;
  for (std::size_t corner = 0; corner < 8; ++corner)
  {
    std::array<double, 4> clip{};
    std::array<double, 4> error{};
    for (std::size_t row = 0; row < 4; ++row)
    {
      const double* m = this->Matrix.data() + 4 * row;
      clip[row] = m[3];
      error[row] = std::abs(m[3]);
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        const double bound = static_cast<double>(bounds[2 * axis + ((corner >> axis) & 1)]);
        const double term = m[axis] * (bound - this->Origin[axis]);
        clip[row] += term;
        error[row] += std::abs(term);
      }
      error[row] *= Rounding;
    }
    const double w = clip[3];
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double margin = error[axis] + error[3];
      beyond[2 * axis] += clip[axis] < -w - margin ? 1 : 0;
      beyond[2 * axis + 1] += clip[axis] > w + margin ? 1 : 0;
      const double place = clip[axis] / w;
      const double placeError = (error[axis] + std::abs(place) * error[3]) / (w - error[3]);
      low[axis] = std::min(low[axis], place - placeError);
      high[axis] = std::max(high[axis], place + placeError);
      isKnown = isKnown && std::isfinite(placeError);
    }
    isKnown = isKnown && clip[2] > -w && w > error[3];
  }
  box.IsOutside = std::any_of(beyond.begin(), beyond.end(), [](int count) { return count == 8; });
  if (box.IsOutside || !isKnown)
  {
    return box;
  }
  box.IsKnown = true;
  box.Pixels.Left = ToPixel(std::floor((low[0] + 1) / 2 * this->Width - PixelMargin));
  box.Pixels.Right = ToPixel(std::ceil((high[0] + 1) / 2 * this->Width + PixelMargin));
  box.Pixels.Bottom = ToPixel(std::floor((low[1] + 1) / 2 * this->Height - PixelMargin));
  box.Pixels.Top = ToPixel(std::ceil((high[1] + 1) / 2 * this->Height + PixelMargin));
  box.Depth = static_cast<float>((low[2] + 1) / 2 - DepthMargin);
  return box;
}

} // namespace isosurface
