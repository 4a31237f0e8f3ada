// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CrossingFit_h
#define isosurface_CrossingFit_h

#include "Coding/Prediction/SignRows.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Rows of CrossingFit::RowStride, two more than vertices on either side.
constexpr std::size_t CrossingPlaneSize = (MaximumCodedVertices + 4) * std::size_t(80);

/// The crossings of the edges along one axis that begin in a slice: their positions, in units of
/// 1 / CrossingFit::Unit, and which edges are crossed. Row y is stored at y + 2.
struct CrossingPlane
{
  std::array<std::int16_t, CrossingPlaneSize> Positions;
  std::array<SignRow, MaximumCodedVertices + 4> Crossed;
};
/// [this slice, the one before, the next one][axis]
using CrossingPlanes = std::array<std::array<CrossingPlane, 3>*, 3>;

/**
 * Predicts the crossing of an edge from crossings of edges nearby: the zero of a linear function that
 * is fitted by weighted least squares to 0 at those points and, with little weight, to -0.7 and 0.7
 * at vertices outside and inside. Crossed edges that are not decoded yet count a little, with their
 * middles.
 *
 * All is integers, so that encoders and decoders on every machine agree: sums of products are
 * exact, the mean is subtracted, and the remaining three equations are solved by Cramer's rule.
 */
class CrossingFit
{
public:
  static constexpr std::ptrdiff_t RowStride = 80;
  static constexpr std::ptrdiff_t RowMargin = 8;
  static constexpr std::int32_t Unit = 1024;       ///< of positions on an edge
  static constexpr std::int32_t FineUnit = 65536;  ///< of predicted positions
  static constexpr std::int32_t WeightUnit = 4096; ///< the weight 1
  static constexpr std::int16_t None = -1;         ///< for edges without a crossing
  static constexpr std::int16_t Later = -2;        ///< for crossings that are not decoded yet

  struct Result
  {
    std::int32_t Position = FineUnit / 2; ///< 0 to FineUnit
    int Steepness = 0;                    ///< how straight the surface crosses the edge, 0 to 7
    int Number = 0;                       ///< decoded crossings that were used
  };

  /// The table for all blocks, made by the first call.
  static const CrossingFit& Get();

  /// at: the index of the edge's first vertex (x, y) in a plane; inside: its sign; slices: the signs
  /// of the slice before, this one and the next one.
  Result Predict(int axis, int x, int y, std::ptrdiff_t at, bool inside,
    const std::array<const SignSlice*, 3>& slices, const CrossingPlanes& planes) const;

  /// The weighted mean of crossings of parallel edges nearby.
  Result PredictParallel(
    int axis, int x, int y, std::ptrdiff_t at, const CrossingPlanes& planes) const;

private:
  // An edge nearby: its first vertex relative to the middle of the predicted edge, in Units.
  struct Neighbor
  {
    std::array<std::int32_t, 3> First{};
    std::int32_t Weight = 0;      ///< if it is decoded
    std::int32_t WeightLater = 0; ///< if not
  };
  // The edges along one axis that begin in one row, at x - 2 to x + 2.
  struct NeighborRow
  {
    std::size_t Plane = 0;
    std::size_t Axis = 0;
    int Y = 0;
    std::uint32_t Near = 0; ///< bits of the edges that are near enough
    std::array<Neighbor, 5> Neighbors;
  };
  // Lower triangle of the symmetric matrix, and the right-hand side, of (1, x, y, z).
  struct Equations
  {
    std::array<std::int64_t, 10> A{}; ///< 11 xx yy zz, x y z, xy xz yz
    std::array<std::int64_t, 4> B{};
  };
  // What one row of three vertices around the edge adds to B, for each pattern of their signs.
  struct SignRowSums
  {
    int Y = 0;
    std::size_t Slice = 0;
    std::array<std::array<std::int32_t, 4>, 8> Sums;
  };

  CrossingFit();
  // Calls functor(point, weight, later) for the crossings nearby. point: relative to the middle of
  // the edge, in Units; later: whether the crossing is not decoded yet.
  template <typename Functor>
  void VisitNeighbors(int axis, int x, int y, std::ptrdiff_t at, const CrossingPlanes& planes,
    const Functor& functor) const;
  void MakeNeighbors(int axis);
  void MakeSigns(int axis);
  // The equations without the mean of the points: three unknowns, the slopes.
  struct CenteredEquations
  {
    std::array<std::int64_t, 3> Mean; ///< of the points, in units of 1 / (16 Unit)
    std::int64_t Middle = 0;          ///< mean of the targets, in units of 1 / Unit
    std::array<std::int64_t, 6> S;    ///< xx yy zz, xy xz yz; 18 bits each
    std::array<std::int64_t, 3> B;    ///< 18 bits each
    int Shift = 0;                    ///< by how many bits B was shifted down less than S
  };
  // Slopes times the determinant, and the determinant: at most 38 bits each.
  struct Slopes
  {
    std::array<std::int64_t, 3> Values;
    std::int64_t Determinant = 0;
  };
  static Result Solve(const Equations& equations, int axis, bool inside);
  static CenteredEquations Center(const Equations& equations);
  static bool FindSlopes(const CenteredEquations& equations, Slopes& slopes);
  static Result FindZero(
    const CenteredEquations& equations, const Slopes& slopes, int axis, bool inside);

  std::array<std::vector<NeighborRow>, 3> Rows;
  std::array<std::vector<NeighborRow>, 3> ParallelRows; ///< of the same axis only
  std::array<std::vector<SignRowSums>, 3> Signs;
  std::array<Equations, 3> SignEquations; ///< A of the vertices around an edge
};

// Functions that are called for each edge are inline, so that they are compiled for the instruction
// set of the coder.

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
  const CenteredEquations centered = Center(equations);
  Slopes slopes;
  return FindSlopes(centered, slopes) ? FindZero(centered, slopes, axis, inside) : Result();
}

inline CrossingFit::CenteredEquations CrossingFit::Center(const Equations& equations)
{
  CenteredEquations result;
  const std::array<std::int64_t, 10>& a = equations.A;
  const std::int64_t reciprocal = (std::int64_t{ 1 } << 40) / a[0];
  for (std::size_t n = 0; n < 3; ++n)
  {
    result.Mean[n] = a[4 + n] * reciprocal >> 36;
  }
  result.Middle = equations.B[0] * reciprocal >> 40;
  const auto center = [&](std::size_t entry, std::size_t i, std::size_t j)
  { return a[entry] - (result.Mean[i] * a[4 + j] >> 4); };
  result.S = { center(1, 0, 0), center(2, 1, 1), center(3, 2, 2), center(7, 0, 1), center(8, 0, 2),
    center(9, 1, 2) };
  std::int64_t magnitudes = 0;
  for (std::size_t n = 0; n < 3; ++n)
  {
    result.B[n] = equations.B[n + 1] - (result.Mean[n] * equations.B[0] >> 4);
    magnitudes |= result.B[n] < 0 ? -result.B[n] : result.B[n];
  }
  // With 18 bits each, no product overflows. The common factors cancel.
  const int down = std::max(0, CountFitBits(result.S[0] | result.S[1] | result.S[2]) - 18);
  const int downB = std::max(0, CountFitBits(magnitudes) - 18);
  for (std::int64_t& entry : result.S)
  {
    entry >>= down;
  }
  for (std::int64_t& entry : result.B)
  {
    entry >>= downB;
  }
  result.Shift = down - downB;
  return result;
}

inline bool CrossingFit::FindSlopes(const CenteredEquations& equations, Slopes& slopes)
{
  const std::array<std::int64_t, 6>& s = equations.S;
  const std::array<std::int64_t, 3>& b = equations.B;
  const std::int64_t cofactors[6] = { s[1] * s[2] - s[5] * s[5], s[0] * s[2] - s[4] * s[4],
    s[0] * s[1] - s[3] * s[3], s[4] * s[5] - s[3] * s[2], s[3] * s[5] - s[4] * s[1],
    s[3] * s[4] - s[0] * s[5] };
  const std::int64_t determinant = s[0] * cofactors[0] + s[3] * cofactors[3] + s[4] * cofactors[4];
  if (determinant <= 0)
  {
    return false;
  }
  slopes.Values = { cofactors[0] * b[0] + cofactors[3] * b[1] + cofactors[4] * b[2],
    cofactors[3] * b[0] + cofactors[1] * b[1] + cofactors[5] * b[2],
    cofactors[4] * b[0] + cofactors[5] * b[1] + cofactors[2] * b[2] };
  // The slopes are these / (determinant * 2^Shift). Both are brought to at most 38 bits.
  const int bits = std::max({ CountFitBits(slopes.Values[0]), CountFitBits(slopes.Values[1]),
    CountFitBits(slopes.Values[2]) });
  const int shift = std::max(bits, CountFitBits(determinant) + equations.Shift) - 38;
  const auto move = [](std::int64_t number, int by)
  {
    return by >= 63 ? 0
      : by >= 0     ? number >> by
                    : number * (std::int64_t{ 1 } << std::min(-by, 62));
  };
  for (std::int64_t& slope : slopes.Values)
  {
    slope = move(slope, shift);
  }
  slopes.Determinant = move(determinant, shift - equations.Shift);
  return true;
}

inline CrossingFit::Result CrossingFit::FindZero(
  const CenteredEquations& equations, const Slopes& slopes, int axis, bool inside)
{
  const std::array<std::int64_t, 3>& values = slopes.Values;
  const std::array<std::int64_t, 3>& mean = equations.Mean;
  const std::int64_t sign = inside ? -1 : 1;
  const std::int64_t along =
    std::max(values[static_cast<std::size_t>(axis)] * sign, slopes.Determinant / 50 + 1);
  const std::int64_t height =
    ((values[0] * mean[0] + values[1] * mean[1] + values[2] * mean[2]) >> 4) -
    equations.Middle * slopes.Determinant;
  const std::int64_t offset = height * sign * (FineUnit / Unit) / along;
  Result result;
  result.Position =
    static_cast<std::int32_t>(std::clamp<std::int64_t>(FineUnit / 2 + offset, 0, FineUnit));
  const std::int64_t steep = along >> 10;
  std::int64_t square = 1;
  for (const std::int64_t slope : values)
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
