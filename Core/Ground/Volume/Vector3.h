// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Vector3_h
#define isosurface_Vector3_h

#include <array>

namespace isosurface
{

using Vector3 = std::array<double, 3>;

inline double Dot(const Vector3& a, const Vector3& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Vector3 Cross(const Vector3& a, const Vector3& b)
{
  return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
}

inline Vector3 Subtract(const Vector3& a, const Vector3& b)
{
  return { a[0] - b[0], a[1] - b[1], a[2] - b[2] };
}

} // namespace isosurface

#endif
