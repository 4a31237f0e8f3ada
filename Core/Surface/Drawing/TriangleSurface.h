// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TriangleSurface_h
#define isosurface_TriangleSurface_h

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// The connectivity of triangles, in one of two integer types. The arrays are not owned.
struct TriangleConnectivity
{
  const std::int32_t* Values32 = nullptr; ///< three point numbers a triangle
  const std::int64_t* Values64 = nullptr; ///< the same; used where Values32 is null

  /// The point number of triangle place / 3 at its corner place % 3.
  std::int64_t operator[](std::size_t place) const
  {
    return this->Values32 ? this->Values32[place] : this->Values64[place];
  }
};

/// A surface of triangles in arrays that somebody else owns.
struct TriangleSurface
{
  const float* Points = nullptr; ///< x, y and z of each point
  std::size_t NumberOfPoints = 0;
  TriangleConnectivity Connectivity;
  std::size_t NumberOfTriangles = 0;
};

} // namespace isosurface

#endif
