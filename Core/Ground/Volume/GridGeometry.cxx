// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/GridGeometry.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace isosurface
{

Index3 GridGeometry::GetDimensions() const
{
  Index3 dimensions;
  for (int axis = 0; axis < 3; ++axis)
  {
    dimensions[axis] =
      std::max<std::int64_t>(0, this->Extent[2 * axis + 1] - this->Extent[2 * axis] + 1);
  }
  return dimensions;
}

std::int64_t GridGeometry::GetNumberOfVertices() const
{
  const Index3 dimensions = this->GetDimensions();
  return dimensions[0] * dimensions[1] * dimensions[2];
}

GridGeometry GridGeometry::Coarsen(int level) const
{
  if (level == 0)
  {
    return *this;
  }
  GridGeometry coarse = *this;
  const Index3 dimensions = this->GetDimensions();
  // Rounded as vtkImageData::TransformIndexToPhysicalPoint does.
  for (int row = 0; row < 3; ++row)
  {
    double offset = 0;
    for (int axis = 0; axis < 3; ++axis)
    {
      offset += static_cast<double>(this->Extent[2 * axis]) *
        (this->Direction[3 * row + axis] * this->Spacing[axis]);
    }
    coarse.Origin[row] = offset + this->Origin[row];
  }
  for (int axis = 0; axis < 3; ++axis)
  {
    coarse.Extent[2 * axis] = 0;
    coarse.Extent[2 * axis + 1] = dimensions[axis] == 0 ? -1 : (dimensions[axis] - 1) >> level;
    coarse.Spacing[axis] *= static_cast<double>(std::int64_t{ 1 } << level);
  }
  return coarse;
}

const char* GridGeometry::FindFault() const
{
  const auto areFinite = [](const auto& numbers)
  {
    return std::all_of(
      numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
  };
  if (!areFinite(this->Origin) || !areFinite(this->Spacing) || !areFinite(this->Direction))
  {
    return "has an origin, spacing or direction that is not finite";
  }
  if (std::count(this->Spacing.begin(), this->Spacing.end(), 0.0) > 0)
  {
    return "has a spacing of 0";
  }
  // The determinant of the directions of length 1 is the volume that they span, from 0 to 1.
  double scale = 1;
  const std::array<double, 9>& d = this->Direction;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    scale *= std::hypot(d[axis], d[3 + axis], d[6 + axis]);
  }
  const double determinant = d[0] * (d[4] * d[8] - d[5] * d[7]) -
    d[1] * (d[3] * d[8] - d[5] * d[6]) + d[2] * (d[3] * d[7] - d[4] * d[6]);
  constexpr double flat = 1e-10;
  return std::abs(determinant) > flat * scale && std::isfinite(scale)
    ? nullptr
    : "has directions that lie in a plane";
}

bool GridGeometry::operator==(const GridGeometry& other) const
{
  return this->Extent == other.Extent && this->Origin == other.Origin &&
    this->Spacing == other.Spacing && this->Direction == other.Direction;
}

} // namespace isosurface
