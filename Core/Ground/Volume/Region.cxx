// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/Region.h"

#include "Ground/Volume/Vector3.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace isosurface
{
namespace
{

// Transforms a half-space to structured coordinates, with a normal of length 1.
HalfSpace ToStructured(const GridGeometry& grid, const HalfSpace& world)
{
  HalfSpace structured;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const Vector3 direction{ grid.Direction[axis], grid.Direction[3 + axis],
      grid.Direction[6 + axis] };
    structured.Normal[axis] = Dot(world.Normal, direction) * grid.Spacing[axis];
  }
  structured.Offset = world.Offset - Dot(world.Normal, grid.Origin);
  const double length = std::sqrt(Dot(structured.Normal, structured.Normal));
  if (length > 0)
  {
    for (double& component : structured.Normal)
    {
      component /= length;
    }
    structured.Offset /= length;
  }
  return structured;
}

bool AllContain(const std::vector<HalfSpace>& halfSpaces, const Vector3& point, double tolerance)
{
  return std::all_of(halfSpaces.begin(), halfSpaces.end(),
    [&](const HalfSpace& halfSpace)
    { return Dot(halfSpace.Normal, point) <= halfSpace.Offset + tolerance; });
}

// Whether the half-spaces have a common point. They must bound a finite body, so that it has a
// corner unless it is empty.
bool HaveCommonPoint(const std::vector<HalfSpace>& halfSpaces, double tolerance)
{
  for (std::size_t a = 0; a < halfSpaces.size(); ++a)
  {
    for (std::size_t b = a + 1; b < halfSpaces.size(); ++b)
    {
      const Vector3 line = Cross(halfSpaces[a].Normal, halfSpaces[b].Normal);
      for (std::size_t c = b + 1; c < halfSpaces.size(); ++c)
      {
        const double determinant = Dot(line, halfSpaces[c].Normal);
        if (std::abs(determinant) < 1e-12)
        {
          continue;
        }
        const Vector3 first = Cross(halfSpaces[b].Normal, halfSpaces[c].Normal);
        const Vector3 second = Cross(halfSpaces[c].Normal, halfSpaces[a].Normal);
        Vector3 corner{};
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          corner[axis] = (halfSpaces[a].Offset * first[axis] + halfSpaces[b].Offset * second[axis] +
                           halfSpaces[c].Offset * line[axis]) /
            determinant;
        }
        if (AllContain(halfSpaces, corner, tolerance))
        {
          return true;
        }
      }
    }
  }
  return false;
}

} // namespace

Region::Region(std::vector<HalfSpace> halfSpaces)
  : HalfSpaces(std::move(halfSpaces))
{
}

Region Region::FromBounds(const std::array<double, 6>& bounds)
{
  std::vector<HalfSpace> halfSpaces;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    HalfSpace low;
    low.Normal[axis] = -1;
    low.Offset = -bounds[2 * axis];
    HalfSpace high;
    high.Normal[axis] = 1;
    high.Offset = bounds[2 * axis + 1];
    halfSpaces.push_back(low);
    halfSpaces.push_back(high);
  }
  return Region(std::move(halfSpaces));
}

Region Region::Intersect(const Region& other) const
{
  Region both(*this);
  both.HalfSpaces.insert(both.HalfSpaces.end(), other.HalfSpaces.begin(), other.HalfSpaces.end());
  return both;
}

bool Region::Intersects(const GridGeometry& grid, const VertexBox& vertices) const
{
  if (this->IsEverything())
  {
    return true;
  }
  Vector3 low{};
  Vector3 high{};
  double tolerance = 1e-9;
  std::vector<HalfSpace> cutting;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    low[axis] = static_cast<double>(grid.Extent[2 * axis] + vertices.Low[axis]);
    high[axis] = static_cast<double>(grid.Extent[2 * axis] + vertices.High[axis] - 1);
    tolerance = std::max({ tolerance, 1e-12 * std::abs(low[axis]), 1e-12 * std::abs(high[axis]) });
    HalfSpace side;
    side.Normal[axis] = -1;
    side.Offset = -low[axis];
    cutting.push_back(side);
    side.Normal[axis] = 1;
    side.Offset = high[axis];
    cutting.push_back(side);
  }
  const std::size_t sides = cutting.size();
  for (const HalfSpace& world : this->HalfSpaces)
  {
    const HalfSpace halfSpace = ToStructured(grid, world);
    double minimum = 0;
    double maximum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double a = halfSpace.Normal[axis] * low[axis];
      const double b = halfSpace.Normal[axis] * high[axis];
      minimum += std::min(a, b);
      maximum += std::max(a, b);
    }
    if (minimum > halfSpace.Offset + tolerance)
    {
      return false;
    }
    if (!(maximum <= halfSpace.Offset))
    {
      cutting.push_back(halfSpace);
    }
  }
  return cutting.size() <= sides + 1 || HaveCommonPoint(cutting, tolerance);
}

} // namespace isosurface
