// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/CrossingFit.h"

#include <algorithm>

namespace isosurface
{
namespace
{

constexpr double SignWeight = 0.003;
constexpr double SignTarget = 0.7;
constexpr double LaterWeight = 0.05;
constexpr double Ridge = 1e-3;
constexpr double MostSquaredDistance = 2.8;

double WeighSign(double squared)
{
  return SignWeight / (0.3 + squared);
}

} // namespace

CrossingFit::CrossingFit()
{
  for (int axis = 0; axis < 3; ++axis)
  {
    double middle[3] = { 0, 0, 0 };
    middle[axis] = 0.5;
    std::vector<Neighbor>& neighbors = this->Neighbors[static_cast<std::size_t>(axis)];
    for (int plane = 0; plane < 3; ++plane)
    {
      const int dz = plane == 2 ? 1 : -plane;
      for (int dy = -2; dy <= 2; ++dy)
      {
        for (int dx = -2; dx <= 2; ++dx)
        {
          for (int other = 0; other < 3; ++other)
          {
            Neighbor neighbor{ static_cast<std::size_t>(plane), static_cast<std::size_t>(other),
              dy * RowStride + dx, { dx - middle[0], dy - middle[1], dz - middle[2] }, 0, 0 };
            double squared = 0;
            for (int n = 0; n < 3; ++n)
            {
              const double distance = neighbor.First[n] + (n == other ? 0.5 : 0.0);
              squared += distance * distance;
            }
            if (squared > 0 && squared < MostSquaredDistance)
            {
              neighbor.Weight = 1 / (0.05 + squared * squared);
              neighbor.WeightLater = LaterWeight / (0.3 + squared);
              neighbors.push_back(neighbor);
            }
          }
        }
      }
    }
    // The vertices around the edge: 2 along it, 3 on the axes across.
    Equations& equations = this->SignEquations[static_cast<std::size_t>(axis)];
    equations = {};
    for (int k = axis == 2 ? 0 : -1; k <= 1; ++k)
    {
      for (int j = axis == 1 ? 0 : -1; j <= 1; ++j)
      {
        for (int i = axis == 0 ? 0 : -1; i <= 1; ++i)
        {
          const double f[4] = { 1, i - middle[0], j - middle[1], k - middle[2] };
          const double weight = WeighSign(f[1] * f[1] + f[2] * f[2] + f[3] * f[3]);
          for (int row = 0; row < 4; ++row)
          {
            for (int column = 0; column <= row; ++column)
            {
              equations.A[row][column] += weight * f[row] * f[column];
            }
          }
        }
      }
    }
    for (int row = 0; row < 4; ++row)
    {
      equations.A[row][row] += Ridge;
    }
  }
}

void CrossingFit::AddSigns(
  int axis, int x, int y, const std::array<const SignSlice*, 3>& slices, Equations& equations) const
{
  double middle[3] = { 0, 0, 0 };
  middle[axis] = 0.5;
  for (int k = axis == 2 ? 0 : -1; k <= 1; ++k)
  {
    const SignSlice& slice = *slices[static_cast<std::size_t>(k + 1)];
    for (int j = axis == 1 ? 0 : -1; j <= 1; ++j)
    {
      const std::uint32_t window = slice.At(y + j).GetWindow(x);
      const double fy = j - middle[1];
      const double fz = k - middle[2];
      double sum = 0;
      double sumX = 0;
      for (int i = axis == 0 ? 0 : -1; i <= 1; ++i)
      {
        const double fx = i - middle[0];
        const double weight = WeighSign(fx * fx + fy * fy + fz * fz) * SignTarget;
        const double signedWeight = (window >> (i + 2) & 1) != 0 ? weight : -weight;
        sum += signedWeight;
        sumX += signedWeight * fx;
      }
      equations.B[0] += sum;
      equations.B[1] += sumX;
      equations.B[2] += sum * fy;
      equations.B[3] += sum * fz;
    }
  }
}

bool CrossingFit::Solve(Equations& equations)
{
  double(&a)[4][4] = equations.A;
  double(&b)[4] = equations.B;
  double inverse[4];
  for (int row = 0; row < 4; ++row)
  {
    for (int column = 0; column < row; ++column)
    {
      double sum = a[row][column];
      for (int n = 0; n < column; ++n)
      {
        sum -= a[row][n] * a[column][n] * a[n][n];
      }
      a[row][column] = sum * inverse[column];
    }
    double sum = a[row][row];
    for (int n = 0; n < row; ++n)
    {
      sum -= a[row][n] * a[row][n] * a[n][n];
    }
    if (!(sum > 1e-12))
    {
      return false;
    }
    a[row][row] = sum;
    inverse[row] = 1 / sum;
    for (int n = 0; n < row; ++n)
    {
      b[row] -= a[row][n] * b[n];
    }
  }
  for (int row = 3; row >= 0; --row)
  {
    b[row] *= inverse[row];
    for (int n = row + 1; n < 4; ++n)
    {
      b[row] -= a[n][row] * b[n];
    }
  }
  return true;
}

CrossingFit::Result CrossingFit::Predict(int axis, int x, int y, std::ptrdiff_t at, bool inside,
  const std::array<const SignSlice*, 3>& slices, const CrossingPositions& positions) const
{
  Result result;
  Equations equations = this->SignEquations[static_cast<std::size_t>(axis)];
  this->AddSigns(axis, x, y, slices, equations);
  double(&a)[4][4] = equations.A;
  for (const Neighbor& neighbor : this->Neighbors[static_cast<std::size_t>(axis)])
  {
    const float position =
      positions[neighbor.Plane][neighbor.Axis][static_cast<std::size_t>(at + neighbor.Offset)];
    if (position == None)
    {
      continue;
    }
    const bool later = position < 0;
    double point[3] = { neighbor.First[0], neighbor.First[1], neighbor.First[2] };
    point[neighbor.Axis] += later ? 0.5 : static_cast<double>(position);
    const double weight = later ? neighbor.WeightLater : neighbor.Weight;
    const double wx = weight * point[0];
    const double wy = weight * point[1];
    const double wz = weight * point[2];
    a[0][0] += weight;
    a[1][0] += wx;
    a[2][0] += wy;
    a[3][0] += wz;
    a[1][1] += wx * point[0];
    a[2][1] += wx * point[1];
    a[3][1] += wx * point[2];
    a[2][2] += wy * point[1];
    a[3][2] += wy * point[2];
    a[3][3] += wz * point[2];
    result.Number += later ? 0 : 1;
  }
  if (!Solve(equations))
  {
    return result;
  }
  const double sign = inside ? -1 : 1;
  const double* c = equations.B;
  const double slope = std::max(c[1 + axis] * sign, 0.02);
  result.Position = std::clamp(0.5 - c[0] * sign / slope, 0.0, 1.0);
  const double square = c[1] * c[1] + c[2] * c[2] + c[3] * c[3];
  result.Steepness = std::clamp(static_cast<int>(8 * slope * slope / (square + 1e-9)), 0, 7);
  return result;
}

CrossingFit::Result CrossingFit::PredictParallel(
  int axis, std::ptrdiff_t at, const CrossingPositions& positions) const
{
  Result result;
  double sum = 0.125;
  double weight = 0.25;
  for (const Neighbor& neighbor : this->Neighbors[static_cast<std::size_t>(axis)])
  {
    if (neighbor.Axis != static_cast<std::size_t>(axis))
    {
      continue;
    }
    const float position =
      positions[neighbor.Plane][neighbor.Axis][static_cast<std::size_t>(at + neighbor.Offset)];
    if (position >= 0)
    {
      const double height = neighbor.First[axis] + 0.5 + static_cast<double>(position);
      sum += neighbor.Weight * height;
      weight += neighbor.Weight;
      ++result.Number;
    }
  }
  result.Position = std::clamp(sum / weight, 0.0, 1.0);
  return result;
}

} // namespace isosurface
