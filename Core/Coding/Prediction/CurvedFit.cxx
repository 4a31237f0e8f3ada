// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Prediction/CurvedFit.h"

namespace isosurface
{
namespace
{

// Weights times Unit^2 that keep the equations solvable: of 1, x, y, z, and of the quadratic terms.
constexpr std::int64_t RidgeOfSlopes = std::int64_t{ 4 } << 20;
constexpr std::int64_t RidgeOfSquares = std::int64_t{ 41 } << 20;

} // namespace

const CurvedFit& CurvedFit::Get()
{
  static const CurvedFit fit;
  return fit;
}

CurvedFit::CurvedFit()
{
  for (int axis = 0; axis < 3; ++axis)
  {
    this->MakeSigns(axis);
  }
}

void CurvedFit::MakeSigns(int axis)
{
  const auto edgeAxis = static_cast<std::size_t>(axis);
  Solver::Equations& equations = this->SignEquations[edgeAxis];
  for (int k = axis == 2 ? 0 : -1; k <= 1; ++k)
  {
    for (int j = axis == 1 ? 0 : -1; j <= 1; ++j)
    {
      SignRowSums row;
      row.Y = j;
      row.Slice = static_cast<std::size_t>(k + 1);
      for (int i = axis == 0 ? 0 : -1; i <= 1; ++i)
      {
        const std::int32_t weight = CrossingFit::WeighVertex(axis, { i, j, k });
        std::array<std::int32_t, 3> point{ Unit * i, Unit * j, Unit * k };
        point[edgeAxis] -= Unit / 2;
        const Terms terms = MakeTerms(point);
        Add(terms, weight, equations);
        this->TargetSquares[edgeAxis] += std::int64_t{ weight } * SignTarget * SignTarget;
        for (std::size_t signs = 0; signs < 8; ++signs)
        {
          const std::int64_t target = (signs >> (i + 1) & 1) != 0 ? SignTarget : -SignTarget;
          for (std::size_t n = 0; n < NumberOfTerms; ++n)
          {
            row.Sums[signs][n] += weight * target * terms[n];
          }
        }
      }
      this->Signs[edgeAxis].push_back(row);
    }
  }
  for (std::size_t n = 0; n < NumberOfTerms; ++n)
  {
    equations[n][n] += n < 4 ? RidgeOfSlopes : RidgeOfSquares;
  }
}

} // namespace isosurface
