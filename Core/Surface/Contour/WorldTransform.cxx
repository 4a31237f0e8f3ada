// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/WorldTransform.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace isosurface
{
namespace
{

using Matrix = std::array<double, 9>;

// Expanded along the first column, as VTK does.
double ComputeDeterminant(const Matrix& m)
{
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[3] * (m[1] * m[8] - m[2] * m[7]) +
    m[6] * (m[1] * m[5] - m[2] * m[4]);
}

// The transposed adjoint divided by the determinant. Returns a singular matrix unchanged.
Matrix InvertAndTranspose(const Matrix& m, double determinant)
{
  Matrix inverse = m;
  if (determinant != 0.0)
  {
    inverse = { m[4] * m[8] - m[5] * m[7], -(m[3] * m[8] - m[5] * m[6]), m[3] * m[7] - m[4] * m[6],
      -(m[1] * m[8] - m[2] * m[7]), m[0] * m[8] - m[2] * m[6], -(m[0] * m[7] - m[1] * m[6]),
      m[1] * m[5] - m[2] * m[4], -(m[0] * m[5] - m[2] * m[3]), m[0] * m[4] - m[1] * m[3] };
    for (double& element : inverse)
    {
      element /= determinant;
    }
  }
  return inverse;
}

} // namespace

WorldTransform MakeWorldTransform(const GridGeometry& geometry, bool normalsByDirection)
{
  WorldTransform transform{};
  bool rotates = false;
  bool moves = false;
  for (int row = 0; row < 3; ++row)
  {
    transform.Origin[row] = geometry.Origin[row];
    moves = moves || geometry.Origin[row] != 0.0;
    rotates = rotates || geometry.Spacing[row] != 1.0;
    for (int column = 0; column < 3; ++column)
    {
      const double direction = geometry.Direction[3 * row + column];
      rotates = rotates || direction != (row == column ? 1.0 : 0.0);
      transform.Points[4 * row + column] = direction * geometry.Spacing[column];
    }
    transform.Points[4 * row + 3] = geometry.Origin[row];
  }
  transform.Steps = rotates ? WorldTransform::Kind::Matrix
    : moves                 ? WorldTransform::Kind::Translation
                            : WorldTransform::Kind::Identity;

  const double determinant = ComputeDeterminant(geometry.Direction);
  transform.Determinant = std::abs(determinant);
  const Matrix normals =
    normalsByDirection ? geometry.Direction : InvertAndTranspose(geometry.Direction, determinant);
  std::copy(normals.begin(), normals.end(), transform.Normals);
  std::copy(geometry.Spacing.begin(), geometry.Spacing.end(), transform.Spacing);
  return transform;
}

} // namespace isosurface
