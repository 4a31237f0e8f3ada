// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/CrossingFit.h"

#include <algorithm>

namespace isosurface
{
namespace
{

// Weights are in units of 2^-12. Squared distances of middles of edges are whole quarters.
constexpr std::int32_t WeightUnit = 4096;
constexpr std::int32_t Ridge = 4;
constexpr std::int32_t SignTarget = 717; ///< 0.7 Units
constexpr int MostSquaredQuarters = 11;  ///< 2.75

// About 1 / (0.05 + d^4): q is 4 d^2.
std::int32_t WeighCrossing(int q)
{
  return 320 * WeightUnit / (16 + 20 * q * q);
}

// About 0.05 / (0.3 + d^2).
std::int32_t WeighLater(int q)
{
  return 2 * WeightUnit / (12 + 10 * q);
}

// About 0.003 / (0.3 + d^2).
std::int32_t WeighSign(int q)
{
  return std::max(1, 12 * WeightUnit / (100 * (12 + 10 * q)));
}

int CountBits(std::int64_t number)
{
  const auto magnitude = static_cast<std::uint64_t>(number < 0 ? -number : number);
  return magnitude == 0 ? 0 : 64 - __builtin_clzll(magnitude);
}

} // namespace

const CrossingFit& CrossingFit::Get()
{
  static const CrossingFit fit;
  return fit;
}

CrossingFit::CrossingFit()
{
  for (int axis = 0; axis < 3; ++axis)
  {
    this->MakeNeighbors(axis);
    this->MakeSigns(axis);
  }
}

void CrossingFit::MakeNeighbors(int axis)
{
  for (int plane = 0; plane < 3; ++plane)
  {
    for (int dy = -2; dy <= 2; ++dy)
    {
      for (int other = 0; other < 3; ++other)
      {
        NeighborRow row;
        row.Plane = static_cast<std::size_t>(plane);
        row.Axis = static_cast<std::size_t>(other);
        row.Y = dy;
        for (int dx = -2; dx <= 2; ++dx)
        {
          const int step[3] = { dx, dy, plane == 2 ? 1 : -plane };
          Neighbor& neighbor = row.Neighbors[static_cast<std::size_t>(dx + 2)];
          int quarters = 0;
          for (int n = 0; n < 3; ++n)
          {
            neighbor.First[static_cast<std::size_t>(n)] =
              Unit * step[n] - (n == axis ? Unit / 2 : 0);
            const int halves = 2 * step[n] - (n == axis ? 1 : 0) + (n == other ? 1 : 0);
            quarters += halves * halves;
          }
          if (quarters > 0 && quarters <= MostSquaredQuarters)
          {
            neighbor.Weight = WeighCrossing(quarters);
            neighbor.WeightLater = WeighLater(quarters);
            row.Near |= 1u << (dx + 2);
          }
        }
        if (row.Near != 0)
        {
          this->Rows[static_cast<std::size_t>(axis)].push_back(row);
          if (other == axis && plane != 2)
          {
            this->ParallelRows[static_cast<std::size_t>(axis)].push_back(row);
          }
        }
      }
    }
  }
}

void CrossingFit::MakeSigns(int axis)
{
  // The vertices around the edge: 2 along it, 3 on the axes across.
  Equations& equations = this->SignEquations[static_cast<std::size_t>(axis)];
  for (int k = axis == 2 ? 0 : -1; k <= 1; ++k)
  {
    for (int j = axis == 1 ? 0 : -1; j <= 1; ++j)
    {
      SignRowSums row{};
      row.Y = j;
      row.Slice = static_cast<std::size_t>(k + 1);
      for (int i = axis == 0 ? 0 : -1; i <= 1; ++i)
      {
        const int step[3] = { i, j, k };
        std::int64_t f[3];
        int quarters = 0;
        for (int n = 0; n < 3; ++n)
        {
          f[n] = Unit * step[n] - (n == axis ? Unit / 2 : 0);
          const int halves = 2 * step[n] - (n == axis ? 1 : 0);
          quarters += halves * halves;
        }
        const std::int32_t weight = WeighSign(quarters);
        const std::int64_t added[10] = { weight, weight * f[0] * f[0], weight * f[1] * f[1],
          weight * f[2] * f[2], weight * f[0], weight * f[1], weight * f[2], weight * f[0] * f[1],
          weight * f[0] * f[2], weight * f[1] * f[2] };
        for (std::size_t n = 0; n < 10; ++n)
        {
          equations.A[n] += added[n];
        }
        for (std::size_t signs = 0; signs < 8; ++signs)
        {
          const std::int32_t signedWeight =
            ((signs >> (i + 1) & 1) != 0 ? weight : -weight) * SignTarget;
          row.Sums[signs][0] += signedWeight;
          for (std::size_t n = 0; n < 3; ++n)
          {
            row.Sums[signs][n + 1] += static_cast<std::int32_t>(signedWeight * f[n]);
          }
        }
      }
      this->Signs[static_cast<std::size_t>(axis)].push_back(row);
    }
  }
  equations.A[0] += Ridge;
  for (std::size_t n = 1; n < 4; ++n)
  {
    equations.A[n] += std::int64_t(Ridge) * Unit * Unit;
  }
}

CrossingFit::Result CrossingFit::Predict(int axis, int x, int y, std::ptrdiff_t at, bool inside,
  const std::array<const SignSlice*, 3>& slices, const CrossingPlanes& planes) const
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
      std::int32_t point[3] = { neighbor.First[0], neighbor.First[1], neighbor.First[2] };
      point[row.Axis] += later ? Unit / 2 : position;
      const std::int32_t weight = later ? neighbor.WeightLater : neighbor.Weight;
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
    }
  }
  Result result = Solve(equations, axis, inside);
  result.Number = number;
  return result;
}

CrossingFit::Result CrossingFit::Solve(const Equations& equations, int axis, bool inside)
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
  const int down = std::max(0, CountBits(s[0] | s[1] | s[2]) - 18);
  for (std::int64_t& entry : s)
  {
    entry >>= down;
  }
  const int downB = std::max(0, CountBits(largestB) - 18);
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
  int bits = std::max({ CountBits(slopes[0]), CountBits(slopes[1]), CountBits(slopes[2]) });
  int shift = std::max(bits, CountBits(determinant) + down - downB) - 38;
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

CrossingFit::Result CrossingFit::PredictParallel(
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
