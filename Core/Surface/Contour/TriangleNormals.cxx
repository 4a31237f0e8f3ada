// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/TriangleNormals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace isosurface
{
namespace
{

template <typename Id, typename Real>
void AddTriangles(const Buffer<Id>& connectivity, const Real* points, float* normals)
{
  for (std::size_t corner = 0; corner + 2 < connectivity.GetSize(); corner += 3)
  {
    const Real* a = points + 3 * connectivity[corner];
    const Real* b = points + 3 * connectivity[corner + 1];
    const Real* c = points + 3 * connectivity[corner + 2];
    const auto subtract = [a](const Real* point) -> std::array<float, 3>
    {
      return { static_cast<float>(point[0] - a[0]), static_cast<float>(point[1] - a[1]),
        static_cast<float>(point[2] - a[2]) };
    };
    const std::array<float, 3> u = subtract(b);
    const std::array<float, 3> v = subtract(c);
    const std::array<float, 3> product = { u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
      u[0] * v[1] - u[1] * v[0] };
    for (std::size_t n = corner; n < corner + 3; ++n)
    {
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        normals[3 * static_cast<std::size_t>(connectivity[n]) + axis] += product[axis];
      }
    }
  }
}

template <typename Real>
void AddAllTriangles(Surface& surface, const Real* points)
{
  if (surface.Connectivity.Is64Bit)
  {
    AddTriangles(surface.Connectivity.Values64, points, surface.Normals.GetData());
  }
  else
  {
    AddTriangles(surface.Connectivity.Values32, points, surface.Normals.GetData());
  }
}

} // namespace

void ComputeNormalsOfTriangles(Surface& surface)
{
  surface.Normals = Buffer<float>(3 * surface.NumberOfPoints);
  float* normals = surface.Normals.GetData();
  std::fill(surface.Normals.begin(), surface.Normals.end(), 0.0F);
  if (surface.HasDoublePoints)
  {
    AddAllTriangles(surface, surface.DoublePoints.GetData());
  }
  else
  {
    AddAllTriangles(surface, surface.Points.GetData());
  }
  for (std::size_t point = 0; point < surface.NumberOfPoints; ++point, normals += 3)
  {
    const float length =
      std::sqrt(normals[0] * normals[0] + normals[1] * normals[1] + normals[2] * normals[2]);
    for (int axis = 0; axis < 3 && length > 0; ++axis)
    {
      normals[axis] /= length;
    }
  }
}

} // namespace isosurface
