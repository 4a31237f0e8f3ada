// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Prediction/CrossingFit.h"

namespace isosurface
{
namespace
{

// q below is four times the squared distance of the middles of two edges, an integer.
constexpr std::int32_t WeightUnit = CrossingFit::WeightUnit;
constexpr std::int32_t Ridge = 4;          ///< a weight; keeps the equations solvable
constexpr std::int32_t SignTarget = 717;   ///< 0.7 Units
constexpr int MaximumSquaredQuarters = 11; ///< a squared distance of 2.75

// About 1 / (0.05 + d^4), d^2 being q / 4.
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

// step: the offset of the vertex from the first vertex of the edge.
std::int32_t WeighVertex(int axis, const std::array<int, 3>& step)
{
  int quarters = 0;
  for (int n = 0; n < 3; ++n)
  {
    const int halves = 2 * step[static_cast<std::size_t>(n)] - (n == axis ? 1 : 0);
    quarters += halves * halves;
  }
  return WeighSign(quarters);
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
          if (quarters > 0 && quarters <= MaximumSquaredQuarters)
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
        for (int n = 0; n < 3; ++n)
        {
          f[n] = Unit * step[n] - (n == axis ? Unit / 2 : 0);
        }
        const std::int32_t weight = WeighVertex(axis, { i, j, k });
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

} // namespace isosurface
