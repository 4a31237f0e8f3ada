// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CrossingFit_h
#define isosurface_CrossingFit_h

#include "BlockCoding/SignRows.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

constexpr std::size_t CrossingPlaneSize = (MaximumCodedVertices + 4) * std::size_t(80);

/// Where on the edges along one axis that begin at the vertices of a slice the crossings are, in
/// units of 1 / CrossingFit::Unit, and which edges are crossed: row y stands at y + 2.
struct CrossingPlane
{
  std::array<std::int16_t, CrossingPlaneSize> Positions;
  std::array<SignRow, MaximumCodedVertices + 4> Crossed;
};
/// [this slice, the one before, the next one][axis]
using CrossingPlanes = std::array<std::array<CrossingPlane, 3>*, 3>;

/**
 * Predicts where on an edge the surface is, from where it was on edges nearby: the zero of a linear
 * function that is fitted, by weighted least squares, to 0 at those points and, with little weight,
 * to -0.7 and 0.7 at vertices outside and inside. Edges that are crossed but not decoded yet count
 * a little as well, by their middles.
 *
 * In integers throughout, so that encoder and decoder agree on every machine: sums of products are
 * exact, the mean is taken out, and the three equations that are left are solved by Cramer's rule.
 */
class CrossingFit
{
public:
  static constexpr std::ptrdiff_t RowStride = 80;
  static constexpr std::ptrdiff_t RowMargin = 8;
  static constexpr std::int32_t Unit = 1024;       ///< of positions on an edge
  static constexpr std::int32_t FineUnit = 65536;  ///< of predicted ones
  static constexpr std::int32_t WeightUnit = 4096; ///< of 1
  static constexpr std::int16_t None = -1;         ///< for edges without a crossing
  static constexpr std::int16_t Later = -2;        ///< for crossings that are not decoded yet

  struct Result
  {
    std::int32_t Position = FineUnit / 2; ///< 0 to FineUnit
    int Steepness = 0;                    ///< how straight the surface crosses the edge, 0 to 7
    int Number = 0;                       ///< of crossings that were used
  };

  /// The only one; made once.
  static const CrossingFit& Get();

  /// at: the place of the edge's first vertex (x, y) in a plane; inside: its sign; slices: the
  /// signs before, in and after this slice.
  Result Predict(int axis, int x, int y, std::ptrdiff_t at, bool inside,
    const std::array<const SignSlice*, 3>& slices, const CrossingPlanes& planes) const;

  /// The mean of the nearest parallel edges only.
  Result PredictParallel(
    int axis, int x, int y, std::ptrdiff_t at, const CrossingPlanes& planes) const;

  /// Calls functor(point, weight, whether it is not decoded yet) for the crossings nearby; points
  /// as seen from the middle of the edge, in Units.
  template <typename Functor>
  void VisitNeighbors(int axis, int x, int y, std::ptrdiff_t at, const CrossingPlanes& planes,
    const Functor& functor) const;

  /// The weight of a vertex so many steps from the first one of an edge.
  static std::int32_t WeighVertex(int axis, const std::array<int, 3>& step);

private:
  // An edge nearby: its first vertex as seen from the middle of the edge to predict, in Units.
  struct Neighbor
  {
    std::array<std::int32_t, 3> First{};
    std::int32_t Weight = 0;      ///< once it is decoded
    std::int32_t WeightLater = 0; ///< before
  };
  // Those of one row of vertices, x - 2 to x + 2.
  struct NeighborRow
  {
    std::size_t Plane = 0;
    std::size_t Axis = 0;
    int Y = 0;
    std::uint32_t Near = 0; ///< bits of those that are near enough
    std::array<Neighbor, 5> Neighbors;
  };
  // Lower triangle of the symmetric matrix, and the right-hand side, of (1, x, y, z).
  struct Equations
  {
    std::array<std::int64_t, 10> A{}; ///< 11 xx yy zz, x y z, xy xz yz
    std::array<std::int64_t, 4> B{};
  };
  // What the signs of one row of vertices around the edge add to B, by the signs.
  struct SignRowSums
  {
    int Y = 0;
    std::size_t Slice = 0;
    std::array<std::array<std::int32_t, 4>, 8> Sums;
  };

  CrossingFit();
  void MakeNeighbors(int axis);
  void MakeSigns(int axis);
  static Result Solve(const Equations& equations, int axis, bool inside);

  std::array<std::vector<NeighborRow>, 3> Rows;
  std::array<std::vector<NeighborRow>, 3> ParallelRows; ///< of the same axis only
  std::array<std::vector<SignRowSums>, 3> Signs;
  std::array<Equations, 3> SignEquations; ///< A of the vertices around an edge
};

// What is called for each edge is here, so that the coders have it in their own instructions.

/// The length of a magnitude in bits.
inline int CountFitBits(std::int64_t number)
{
  const auto magnitude = static_cast<std::uint64_t>(number < 0 ? -number : number);
  return magnitude == 0 ? 0 : 64 - __builtin_clzll(magnitude);
}

template <typename Functor>
inline void CrossingFit::VisitNeighbors(int axis, int x, int y, std::ptrdiff_t at,
  const CrossingPlanes& planes, const Functor& functor) const
{
  for (const NeighborRow& row : this->Rows[static_cast<std::size_t>(axis)])
  {
    const CrossingPlane& plane = (*planes[row.Plane])[row.Axis];
    std::uint32_t crossed =
      plane.Crossed[static_cast<std::size_t>(y + row.Y + 2)].GetWindow(x) & row.Near;
    const std::int16_t* positions = plane.Positions.data() + at + row.Y * RowStride - 2;
    for (; crossed != 0; crossed &= crossed - 1)
    {
      const int place = __builtin_ctz(crossed);
      const Neighbor& neighbor = row.Neighbors[static_cast<std::size_t>(place)];
      const std::int32_t position = positions[place];
      if (position == None)
      {
        continue;
      }
      const bool later = position < 0;
      std::array<std::int32_t, 3> point = neighbor.First;
      point[row.Axis] += later ? Unit / 2 : position;
      functor(point, later ? neighbor.WeightLater : neighbor.Weight, later);
    }
  }
}

inline CrossingFit::Result CrossingFit::Predict(int axis, int x, int y, std::ptrdiff_t at,
  bool inside, const std::array<const SignSlice*, 3>& slices, const CrossingPlanes& planes) const
{
  Equations equations = this->SignEquations[static_cast<std::size_t>(axis)];
  for (const SignRowSums& row : this->Signs[static_cast<std::size_t>(axis)])
  {
    const std::uint32_t signs = slices[row.Slice]->At(y + row.Y).GetWindow(x) >> 1 & 7;
    for (std::size_t n = 0; n < 4; ++n)
    {
      equations.B[n] += row.Sums[signs][n];
    }
  }
  std::array<std::int64_t, 10>& a = equations.A;
  int number = 0;
  this->VisitNeighbors(axis, x, y, at, planes,
    [&](const std::array<std::int32_t, 3>& point, std::int32_t weight, bool later)
    {
      const std::int64_t wx = std::int64_t(weight) * point[0];
      const std::int64_t wy = std::int64_t(weight) * point[1];
      const std::int64_t wz = std::int64_t(weight) * point[2];
      a[0] += weight;
      a[1] += wx * point[0];
      a[2] += wy * point[1];
      a[3] += wz * point[2];
      a[4] += wx;
      a[5] += wy;
      a[6] += wz;
      a[7] += wx * point[1];
      a[8] += wx * point[2];
      a[9] += wy * point[2];
      number += later ? 0 : 1;
    });
  Result result = Solve(equations, axis, inside);
  result.Number = number;
  return result;
}

inline CrossingFit::Result CrossingFit::Solve(const Equations& equations, int axis, bool inside)
{
  const std::array<std::int64_t, 10>& a = equations.A;
  // The mean of the points, in units of 1 / (16 Unit), and of what is fitted to, of 1 / Unit.
  const std::int64_t reciprocal = (std::int64_t{ 1 } << 40) / a[0];
  std::int64_t mean[3];
  for (std::size_t n = 0; n < 3; ++n)
  {
    mean[n] = a[4 + n] * reciprocal >> 36;
  }
  const std::int64_t middle = equations.B[0] * reciprocal >> 40;
  const auto center = [&](std::size_t entry, std::size_t i, std::size_t j)
  { return a[entry] - (mean[i] * a[4 + j] >> 4); };
  std::int64_t s[6] = { center(1, 0, 0), center(2, 1, 1), center(3, 2, 2), center(7, 0, 1),
    center(8, 0, 2), center(9, 1, 2) };
  std::int64_t b[3];
  std::int64_t largestB = 0;
  for (std::size_t n = 0; n < 3; ++n)
  {
    b[n] = equations.B[n + 1] - (mean[n] * equations.B[0] >> 4);
    largestB |= b[n] < 0 ? -b[n] : b[n];
  }
  // 18 bits each: then nothing below overflows. The common factors cancel.
  const int down = std::max(0, CountFitBits(s[0] | s[1] | s[2]) - 18);
  for (std::int64_t& entry : s)
  {
    entry >>= down;
  }
  const int downB = std::max(0, CountFitBits(largestB) - 18);
  const std::int64_t cofactors[6] = { s[1] * s[2] - s[5] * s[5], s[0] * s[2] - s[4] * s[4],
    s[0] * s[1] - s[3] * s[3], s[4] * s[5] - s[3] * s[2], s[3] * s[5] - s[4] * s[1],
    s[3] * s[4] - s[0] * s[5] };
  std::int64_t determinant = s[0] * cofactors[0] + s[3] * cofactors[3] + s[4] * cofactors[4];
  Result result;
  if (determinant <= 0)
  {
    return result;
  }
  for (std::int64_t& entry : b)
  {
    entry >>= downB;
  }
  std::int64_t slopes[3] = { cofactors[0] * b[0] + cofactors[3] * b[1] + cofactors[4] * b[2],
    cofactors[3] * b[0] + cofactors[1] * b[1] + cofactors[5] * b[2],
    cofactors[4] * b[0] + cofactors[5] * b[1] + cofactors[2] * b[2] };
  // Slopes are these / determinant * 2^(downB - down). Bring both to at most 38 bits.
  int bits =
    std::max({ CountFitBits(slopes[0]), CountFitBits(slopes[1]), CountFitBits(slopes[2]) });
  int shift = std::max(bits, CountFitBits(determinant) + down - downB) - 38;
  const auto move = [](std::int64_t number, int by)
  {
    return by >= 63 ? 0
      : by >= 0     ? number >> by
                    : number * (std::int64_t{ 1 } << std::min(-by, 62));
  };
  for (std::int64_t& slope : slopes)
  {
    slope = move(slope, shift);
  }
  determinant = move(determinant, shift + downB - down);
  const std::int64_t sign = inside ? -1 : 1;
  const std::int64_t along = std::max(slopes[axis] * sign, determinant / 50 + 1);
  const std::int64_t height =
    ((slopes[0] * mean[0] + slopes[1] * mean[1] + slopes[2] * mean[2]) >> 4) - middle * determinant;
  const std::int64_t offset = height * sign * (FineUnit / Unit) / along;
  result.Position =
    static_cast<std::int32_t>(std::clamp<std::int64_t>(FineUnit / 2 + offset, 0, FineUnit));
  const std::int64_t steep = along >> 10;
  std::int64_t square = 1;
  for (const std::int64_t slope : slopes)
  {
    square += (slope >> 10) * (slope >> 10);
  }
  for (int step = 1; step < 8; ++step)
  {
    result.Steepness += 8 * steep * steep >= step * square ? 1 : 0;
  }
  return result;
}

inline CrossingFit::Result CrossingFit::PredictParallel(
  int axis, int x, int y, std::ptrdiff_t at, const CrossingPlanes& planes) const
{
  Result result;
  std::int64_t sum = std::int64_t{ WeightUnit / 4 } * (Unit / 2);
  std::int64_t weight = WeightUnit / 4;
  for (const NeighborRow& row : this->ParallelRows[static_cast<std::size_t>(axis)])
  {
    const CrossingPlane& plane = (*planes[row.Plane])[row.Axis];
    std::uint32_t crossed =
      plane.Crossed[static_cast<std::size_t>(y + row.Y + 2)].GetWindow(x) & row.Near;
    const std::int16_t* positions = plane.Positions.data() + at + row.Y * RowStride - 2;
    for (; crossed != 0; crossed &= crossed - 1)
    {
      const int place = __builtin_ctz(crossed);
      const std::int32_t position = positions[place];
      if (position >= 0)
      {
        const Neighbor& neighbor = row.Neighbors[static_cast<std::size_t>(place)];
        sum += std::int64_t{ neighbor.Weight } *
          (neighbor.First[static_cast<std::size_t>(axis)] + Unit / 2 + position);
        weight += neighbor.Weight;
        ++result.Number;
      }
    }
  }
  result.Position = static_cast<std::int32_t>(
    std::clamp<std::int64_t>(sum * (FineUnit / Unit) / weight, 0, FineUnit));
  return result;
}

} // namespace isosurface

#endif
