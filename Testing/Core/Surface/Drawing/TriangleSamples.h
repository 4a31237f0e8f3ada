// SPDX-License-Identifier: BSD-3-Clause
#ifndef TriangleSamples_h
#define TriangleSamples_h

#include "Surface/Drawing/TriangleSurface.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

/// A surface with arrays of its own, in both integer types.
struct OwnTriangles
{
  std::vector<float> Points;
  std::vector<std::int32_t> Triangles;
  std::vector<std::int64_t> Triangles64;

  isosurface::TriangleSurface GetView() const
  {
    isosurface::TriangleSurface view;
    view.Points = this->Points.data();
    view.NumberOfPoints = this->Points.size() / 3;
    view.Connectivity.Values32 = this->Triangles.data();
    view.NumberOfTriangles = this->Triangles.size() / 3;
    return view;
  }

  isosurface::TriangleSurface GetView64()
  {
    this->Triangles64.assign(this->Triangles.begin(), this->Triangles.end());
    isosurface::TriangleSurface view = this->GetView();
    view.Connectivity.Values32 = nullptr;
    view.Connectivity.Values64 = this->Triangles64.data();
    return view;
  }
};

/// Triangles between random points of a small lattice: many are degenerate, some points are unused.
inline OwnTriangles MakeRandomTriangles(std::size_t points, std::size_t triangles, unsigned seed)
{
  std::mt19937 random(seed);
  OwnTriangles surface;
  std::uniform_int_distribution<int> coordinate(-4, 4);
  for (std::size_t n = 0; n < 3 * points; ++n)
  {
    surface.Points.push_back(0.25F * static_cast<float>(coordinate(random)));
  }
  std::uniform_int_distribution<std::int32_t> point(0, static_cast<std::int32_t>(points) - 1);
  for (std::size_t n = 0; n < 3 * triangles; ++n)
  {
    surface.Triangles.push_back(point(random));
  }
  return surface;
}

/// A sphere of radius 1 around the origin, of 2 * rows * columns triangles.
inline OwnTriangles MakeSphere(int rows, int columns)
{
  const double pi = std::acos(-1.0);
  OwnTriangles sphere;
  for (int row = 0; row <= rows; ++row)
  {
    for (int column = 0; column < columns; ++column)
    {
      const double latitude = pi * (row + 0.5) / (rows + 1);
      const double longitude = 2 * pi * column / columns;
      sphere.Points.push_back(static_cast<float>(std::sin(latitude) * std::cos(longitude)));
      sphere.Points.push_back(static_cast<float>(std::sin(latitude) * std::sin(longitude)));
      sphere.Points.push_back(static_cast<float>(std::cos(latitude)));
    }
  }
  for (int row = 0; row < rows; ++row)
  {
    for (int column = 0; column < columns; ++column)
    {
      const int next = (column + 1) % columns;
      const int here = row * columns;
      const int below = here + columns;
      for (int point :
        { here + column, here + next, below + column, below + column, here + next, below + next })
      {
        sphere.Triangles.push_back(point);
      }
    }
  }
  return sphere;
}

#endif
