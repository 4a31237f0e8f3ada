// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PointPlaces_h
#define isosurface_PointPlaces_h

#include "Surface/Drawing/TriangleSurface.h"

#include <array>
#include <cstddef>

#if defined(__SSE2__)
#  include <emmintrin.h>
#endif

namespace isosurface
{

/// The three coordinates of a point, in a register of the processor where it has such.
class PointVector
{
public:
  PointVector() = default;

  /// A point with three times one value.
  explicit PointVector(float value) { *this = PointVector(value, value, value); }

#if defined(__SSE2__)
  PointVector(float x, float y, float z)
    : Values(_mm_set_ps(0.0F, z, y, x))
  {
  }
  /// Reads four floats: the fourth is ignored, and has to be there.
  static PointVector Load(const float* point)
  {
    return PointVector(_mm_loadu_ps(point));
  }

  /// By coordinate: the first value if it is less, else the second one, also if one is a NaN.
  friend PointVector Minimum(PointVector a, PointVector b)
  {
    return PointVector(_mm_min_ps(a.Values, b.Values));
  }
  /// By coordinate: the first value if it is greater, else the second one, also if one is a NaN.
  friend PointVector Maximum(PointVector a, PointVector b)
  {
    return PointVector(_mm_max_ps(a.Values, b.Values));
  }
  /// 1 if two points have the same coordinates, else 0. A NaN is no coordinate's equal.
  friend int AreInOnePlace(PointVector a, PointVector b)
  {
    constexpr int allThree = 7;
    return (_mm_movemask_ps(_mm_cmpeq_ps(a.Values, b.Values)) & allThree) == allThree ? 1 : 0;
  }
  std::array<float, 3> GetCoordinates() const
  {
    alignas(16) std::array<float, 4> values{};
    _mm_store_ps(values.data(), this->Values);
    return { values[0], values[1], values[2] };
  }

private:
  explicit PointVector(__m128 values)
    : Values(values)
  {
  }

  __m128 Values{};
#else
  PointVector(float x, float y, float z)
    : Values{ x, y, z }
  {
  }
  static PointVector Load(const float* point)
  {
    return { point[0], point[1], point[2] };
  }

  friend PointVector Minimum(PointVector a, PointVector b)
  {
    return { a.Values[0] < b.Values[0] ? a.Values[0] : b.Values[0],
      a.Values[1] < b.Values[1] ? a.Values[1] : b.Values[1],
      a.Values[2] < b.Values[2] ? a.Values[2] : b.Values[2] };
  }
  friend PointVector Maximum(PointVector a, PointVector b)
  {
    return { a.Values[0] > b.Values[0] ? a.Values[0] : b.Values[0],
      a.Values[1] > b.Values[1] ? a.Values[1] : b.Values[1],
      a.Values[2] > b.Values[2] ? a.Values[2] : b.Values[2] };
  }
  friend int AreInOnePlace(PointVector a, PointVector b)
  {
    return a.Values == b.Values ? 1 : 0;
  }
  std::array<float, 3> GetCoordinates() const
  {
    return this->Values;
  }

private:
  std::array<float, 3> Values{};
#endif
};

/// A point by its number; behind the last one there is no fourth float.
inline PointVector LoadPoint(const TriangleSurface& surface, std::size_t number)
{
  const float* point = surface.Points + 3 * number;
  return number + 1 < surface.NumberOfPoints ? PointVector::Load(point)
                                             : PointVector(point[0], point[1], point[2]);
}

/// Whether the corners of a triangle are in three places. VTK's mappers draw only such triangles.
[[gnu::always_inline]] inline bool AreProperCorners(PointVector a, PointVector b, PointVector c)
{
  // No branches: the processor could not predict which points are in one place.
  return (AreInOnePlace(a, b) | AreInOnePlace(b, c) | AreInOnePlace(a, c)) == 0;
}

/// Calls body(point numbers) with those of the two arrays that is there.
template <typename BodyT>
void WithConnectivity(const TriangleConnectivity& connectivity, BodyT&& body)
{
  if (connectivity.Values32)
  {
    body(connectivity.Values32);
  }
  else
  {
    body(connectivity.Values64);
  }
}

} // namespace isosurface

#endif
