// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CurvedFit_h
#define isosurface_CurvedFit_h

#include "Coding/Prediction/CrossingFit.h"
#include "Coding/Prediction/LeastSquares.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Predicts the crossing of an edge from the same crossings and signs as CrossingFit, with the same
 * weights, by a linear and by a quadratic function. The first is better where crossings are noisy,
 * the second where surfaces are curved. All is integers, see LeastSquares.
 */
class CurvedFit
{
public:
  struct Result
  {
    /// The crossing by the linear and by the quadratic function, 0 to FineUnit.
    std::int32_t Linear = CrossingFit::FineUnit / 2;
    std::int32_t Quadratic = CrossingFit::FineUnit / 2;
    int Steepness = 0; ///< as in CrossingFit::Result, of the quadratic function
    int Number = 0;    ///< decoded crossings that were used
  };

  /// The table for all blocks, made by the first call.
  static const CurvedFit& Get();

  /// Arguments: see CrossingFit::Predict.
  Result Predict(int axis, int x, int y, std::ptrdiff_t at, bool inside,
    const std::array<const SignSlice*, 3>& slices, const CrossingPlanes& planes) const;

private:
  static constexpr int NumberOfTerms = 10; ///< 1 x y z, xx yy zz, xy xz yz
  static constexpr std::int32_t Unit = CrossingFit::Unit;
  /// 2.8 Units. Four times that of CrossingFit: zeros are the same, coefficients have two more
  /// bits.
  static constexpr std::int32_t SignTarget = 2868;
  static constexpr std::int32_t MinimumSlope = 5243;        ///< 0.08 in units of coefficients
  static constexpr std::int32_t MinimumNewtonSlope = 13107; ///< 0.2
  static constexpr int NumberOfSteps = 3;                   ///< of Newton's method

  using Solver = LeastSquares<NumberOfTerms>;
  using Terms = std::array<std::int32_t, NumberOfTerms>;
  using Coefficients = Solver::Weights;

  // What one row of three vertices around the edge adds, for each pattern of their signs.
  struct SignRowSums
  {
    int Y = 0;
    std::size_t Slice = 0;
    std::array<std::array<std::int64_t, NumberOfTerms>, 8> Sums{};
  };

  CurvedFit();
  void MakeSigns(int axis);

  static Terms MakeTerms(const std::array<std::int32_t, 3>& point)
  {
    const auto multiply = [](std::int32_t a, std::int32_t b) { return a * b >> 10; };
    return { Unit, point[0], point[1], point[2], multiply(point[0], point[0]),
      multiply(point[1], point[1]), multiply(point[2], point[2]), multiply(point[0], point[1]),
      multiply(point[0], point[2]), multiply(point[1], point[2]) };
  }
  static void Add(const Terms& terms, std::int32_t weight, Solver::Equations& equations)
  {
    for (std::size_t i = 0; i < NumberOfTerms; ++i)
    {
      const std::int64_t weighted = std::int64_t{ weight } * terms[i];
      for (std::size_t j = 0; j <= i; ++j)
      {
        equations[i][j] += weighted * terms[j];
      }
    }
  }
  static void FindRoots(const Coefficients& linear, const Coefficients& quadratic, int axis,
    bool inside, Result& result);

  std::array<std::vector<SignRowSums>, 3> Signs;
  std::array<Solver::Equations, 3> SignEquations{}; ///< of the vertices around an edge
  std::array<std::int64_t, 3> TargetSquares{};      ///< their weighted squared targets, added up
};

// Functions that are called for each edge are inline, so that they are compiled for the instruction
// set of the coder.

inline CurvedFit::Result CurvedFit::Predict(int axis, int x, int y, std::ptrdiff_t at, bool inside,
  const std::array<const SignSlice*, 3>& slices, const CrossingPlanes& planes) const
{
  const auto edgeAxis = static_cast<std::size_t>(axis);
  Solver::Equations equations = this->SignEquations[edgeAxis];
  for (const SignRowSums& row : this->Signs[edgeAxis])
  {
    const std::uint32_t signs = slices[row.Slice]->At(y + row.Y).GetWindow(x) >> 1 & 7;
    for (std::size_t n = 0; n < NumberOfTerms; ++n)
    {
      equations[NumberOfTerms][n] += row.Sums[signs][n];
    }
  }
  Result result;
  CrossingFit::Get().VisitNeighbors(axis, x, y, at, planes,
    [&](const std::array<std::int32_t, 3>& point, std::int32_t weight, bool later)
    {
      Add(MakeTerms(point), weight, equations);
      result.Number += later ? 0 : 1;
    });
  Solver solver;
  if (solver.Factor(equations, this->TargetSquares[edgeAxis]))
  {
    Coefficients linear;
    Coefficients quadratic;
    solver.Substitute(4, linear);
    solver.Substitute(NumberOfTerms, quadratic);
    FindRoots(linear, quadratic, axis, inside, result);
  }
  return result;
}

inline void CurvedFit::FindRoots(
  const Coefficients& linear, const Coefficients& quadratic, int axis, bool inside, Result& result)
{
  constexpr std::int64_t unit = CrossingFit::FineUnit;
  constexpr std::int64_t half = unit / 2;
  const std::int64_t sign = inside ? -1 : 1;
  const auto place = static_cast<std::size_t>(axis);
  const auto step = [=](std::int64_t from, std::int64_t height, std::int64_t slope)
  { return std::clamp(from - height * unit / slope, -half, half); };
  result.Linear = static_cast<std::int32_t>(half +
    step(0, sign * linear[0], std::max<std::int64_t>(sign * linear[1 + place], MinimumSlope)));

  const std::int64_t constant = sign * quadratic[0];
  const std::int64_t slope = sign * quadratic[1 + place];
  const std::int64_t bend = sign * quadratic[4 + place];
  const std::int64_t steep = std::max<std::int64_t>(slope, MinimumSlope);
  std::int64_t root = step(0, constant, steep);
  for (int n = 0; n < NumberOfSteps; ++n)
  {
    const std::int64_t height = constant + (root * (slope + (bend * root >> 16)) >> 16);
    const std::int64_t now = slope + (2 * bend * root >> 16);
    root = step(root, height, std::max<std::int64_t>(now, MinimumNewtonSlope));
  }
  result.Quadratic = static_cast<std::int32_t>(half + root);

  std::int64_t square = 1;
  for (std::size_t n = 1; n < 4; ++n)
  {
    square += std::int64_t{ quadratic[n] } * quadratic[n];
  }
  for (int n = 1; n < 8; ++n)
  {
    result.Steepness += 8 * steep * steep >= n * square ? 1 : 0;
  }
}

} // namespace isosurface

#endif
