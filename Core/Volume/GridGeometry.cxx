// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/GridGeometry.h"

#include <algorithm>

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

bool GridGeometry::operator==(const GridGeometry& other) const
{
  return this->Extent == other.Extent && this->Origin == other.Origin &&
    this->Spacing == other.Spacing && this->Direction == other.Direction;
}

} // namespace isosurface
