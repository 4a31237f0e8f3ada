// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/CellMeasure.h"

#include "Ground/Base/ProcessorClones.h"

#include <cmath>
#include <limits>

namespace isosurface
{
namespace
{

/// The minimum width of a cell's values, in bins, so that there is no division by 0.
constexpr float MinimumWidth = 1e-6f;
/// The maximum area in a cell, relative to its largest face. Only rounding errors of tiny widths
/// exceed it.
constexpr float MaximumDensity = 8;

constexpr float OverFortyEight = 1.0f / 48;

float Square(float value)
{
  return value * value;
}

/// As std::min and std::max. If an argument is NaN, the result is one of both.
float Minimum(float a, float b)
{
  return a < b ? a : b;
}
float Maximum(float a, float b)
{
  return a > b ? a : b;
}

// Inlined, so that it is compiled for several processors, too.
template <bool ArePerpendicular>
[[gnu::always_inline]] inline void Measure(const RowPointers& pointers, std::int64_t cells,
  const MeasureWeights& weights, float bins, float one)
{
  const float *a = pointers.Values[0], *b = pointers.Values[1], *c = pointers.Values[2],
              *d = pointers.Values[3];
  std::int32_t *from = pointers.From, *to = pointers.To, *area = pointers.Area,
               *first = pointers.First, *slope = pointers.Slope;
  const MeasureWeights weight = weights;
  const auto lastBin = static_cast<std::int32_t>(bins);
#if !defined(__clang__)
#  pragma GCC ivdep
#endif
  for (std::int64_t i = 0; i < cells; ++i)
  {
    const float a0 = a[i], a1 = a[i + 1], b0 = b[i], b1 = b[i + 1];
    const float c0 = c[i], c1 = c[i + 1], d0 = d[i], d1 = d[i + 1];
    const float sum0 = (a0 + b0) + (c0 + d0), sum1 = (a1 + b1) + (c1 + d1);
    const float y0 = (b0 - a0) + (d0 - c0), y1 = (b1 - a1) + (d1 - c1);
    const float z0 = (c0 - a0) + (d0 - b0), z1 = (c1 - a1) + (d1 - b1);
    const float yz0 = (d0 - c0) - (b0 - a0), yz1 = (d1 - c1) - (b1 - a1);
    const float mean = (sum0 + sum1) / 8;
    const float gx = Square(sum1 - sum0) / 16;
    const float gy = Square(y0 + y1) / 16;
    const float gz = Square(z0 + z1) / 16;
    const float hxy = Square(y1 - y0) * OverFortyEight; // a twelfth of the square, as below
    const float hxz = Square(z1 - z0) * OverFortyEight;
    const float hyz = Square(yz0 + yz1) * OverFortyEight;
    const float k = Square(yz1 - yz0) * (OverFortyEight / 3);
    const float variance = gx + gy + gz + hxy + hxz + hyz + k; // times 12
    float gradient = weight.X * gx + weight.Y * gy + weight.Z * gz + weight.XY * hxy +
      weight.XZ * hxz + weight.YZ * hyz + weight.XYZ * k;
    if constexpr (!ArePerpendicular)
    {
      const float x = sum1 - sum0, y = y0 + y1, z = z0 + z1;
      const float xy = y1 - y0, xz = z1 - z0, yz = yz0 + yz1;
      gradient += weight.XTimesY * (x * y / 16 + xz * yz * OverFortyEight) +
        weight.XTimesZ * (x * z / 16 + xy * yz * OverFortyEight) +
        weight.YTimesZ * (y * z / 16 + xy * xz * OverFortyEight);
      gradient = Maximum(gradient, 0);
    }

    const float low =
      Minimum(Minimum(Minimum(a0, a1), Minimum(b0, b1)), Minimum(Minimum(c0, c1), Minimum(d0, d1)));
    const float high =
      Maximum(Maximum(Maximum(a0, a1), Maximum(b0, b1)), Maximum(Maximum(c0, c1), Maximum(d0, d1)));
    const bool isFinite = variance <= std::numeric_limits<float>::max(); // neither is NaN
    const float middle = isFinite ? mean : 0;
    const float widest = isFinite ? Minimum(middle - low, high - middle) : 0;
    const float radius = Minimum(std::sqrt(isFinite ? variance : 0) / 2, widest);
    const float begin = Minimum(Maximum(middle - radius, 0), bins);
    const float end = Minimum(Maximum(middle + radius, 0), bins);
    const float steepness = 1 / Maximum(end - begin, MinimumWidth);
    const std::int32_t beginBin = static_cast<std::int32_t>(begin) + 1;
    const std::int32_t endBin = static_cast<std::int32_t>(end) + 1;
    const float rest = (end - static_cast<float>(beginBin)) * steepness;
    const float density = std::sqrt(isFinite ? gradient : 0) * steepness;
    from[i] = isFinite ? (beginBin < lastBin ? beginBin : lastBin) : 0;
    to[i] = isFinite ? (endBin < lastBin ? endBin : lastBin) : 0;
    // Rounds numbers that are not negative; std::lround would keep the loop from being vectorised.
    // NOLINTBEGIN(bugprone-incorrect-roundings)
    area[i] = static_cast<std::int32_t>(Minimum(density, MaximumDensity) * one + 0.5f);
    first[i] = static_cast<std::int32_t>(Minimum(Maximum(rest, 0), 1) * one + 0.5f);
    // The volume of steeper cells is 0 at the next bin.
    slope[i] = static_cast<std::int32_t>(Minimum(steepness, 1) * one + 0.5f);
    // NOLINTEND(bugprone-incorrect-roundings)
  }
}

ISOSURFACE_CLONES void MeasurePerpendicular(const RowPointers& pointers, std::int64_t cells,
  const MeasureWeights& weights, float bins, float one)
{
  Measure<true>(pointers, cells, weights, bins, one);
}

ISOSURFACE_CLONES void MeasureOblique(const RowPointers& pointers, std::int64_t cells,
  const MeasureWeights& weights, float bins, float one)
{
  Measure<false>(pointers, cells, weights, bins, one);
}

} // namespace

void MeasureCells(const RowPointers& pointers, std::int64_t cells, const MeasureWeights& weights,
  float bins, float one)
{
  const bool arePerpendicular =
    weights.XTimesY == 0 && weights.XTimesZ == 0 && weights.YTimesZ == 0;
  (arePerpendicular ? MeasurePerpendicular : MeasureOblique)(pointers, cells, weights, bins, one);
}

} // namespace isosurface
