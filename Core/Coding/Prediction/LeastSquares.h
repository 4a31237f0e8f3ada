// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LeastSquares_h
#define isosurface_LeastSquares_h

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace isosurface
{

/**
 * Solves normal equations of `Size` unknowns in integers, so that the result is the same on every
 * machine. The equations are scaled to 58 bits and solved by Cholesky's factorisation, with factors
 * of 30 bits. A ridge of 2^-16 of the maximum diagonal entry keeps them solvable.
 */
template <int Size>
class LeastSquares
{
public:
  static constexpr int WeightBits = 16;

  /// Lower triangle of the products of inputs; the last row has the products with the target.
  using Equations = std::array<std::array<std::int64_t, Size>, Size + 1>;

  using Weights = std::array<std::int32_t, Size>;

  /// Factors the equations; false if they cannot be solved. targetSquare: the product of the target
  /// with itself.
  bool Factor(const Equations& products, std::int64_t targetSquare)
  {
    std::int64_t maximum = targetSquare | 1;
    for (std::size_t n = 0; n < Size; ++n)
    {
      maximum = std::max(maximum, products[n][n]);
    }
    const std::int64_t scale = std::int64_t{ 1 } << (__builtin_clzll(maximum) - 6);
    for (std::size_t i = 0; i <= Size; ++i)
    {
      for (std::size_t j = 0; j < std::min<std::size_t>(i + 1, Size); ++j)
      {
        std::int64_t sum = 0;
        for (std::size_t k = 0; k < j; ++k)
        {
          sum += std::int64_t{ this->Factors[i][k] } * this->Factors[j][k];
        }
        sum = products[i][j] * scale - sum;
        if (i != j)
        {
          this->Factors[i][j] = Divide(sum, this->Reciprocals[j], MaximumFactor);
          continue;
        }
        sum += Ridge;
        if (sum < MinimumPivot)
        {
          return false;
        }
        this->Factors[i][i] = FindRoot(sum);
        this->Reciprocals[i] = (std::int64_t{ 1 } << ReciprocalBits) / this->Factors[i][i];
      }
    }
    return true;
  }

  /// Computes the weights of a fit to the first `count` inputs alone, in units of 2^-WeightBits.
  /// Only after Factor returned true.
  void Substitute(std::size_t count, Weights& weights) const
  {
    for (std::size_t i = count; i-- > 0;)
    {
      std::int64_t sum = std::int64_t{ this->Factors[Size][i] } * (1 << WeightBits);
      for (std::size_t k = i + 1; k < count; ++k)
      {
        sum -= std::int64_t{ this->Factors[k][i] } * weights[k];
      }
      weights[i] = Divide(sum, this->Reciprocals[i], MaximumWeight);
    }
  }

private:
  static constexpr int ReciprocalBits = 60;
  static constexpr std::int64_t Ridge = std::int64_t{ 1 } << 42;
  static constexpr std::int64_t MinimumPivot = std::int64_t{ 1 } << 40;
  // With these bounds, sums of products stay below 2^63.
  static constexpr std::int64_t MaximumFactor = 1 << 29;
  static constexpr std::int64_t MaximumWeight = 8 << WeightBits;

  // sum / divisor, rounded down, by the divisor's reciprocal; within -maximum .. maximum.
  static std::int32_t Divide(std::int64_t sum, std::int64_t reciprocal, std::int64_t maximum)
  {
    __extension__ using Wide = __int128;
    const auto quotient = static_cast<std::int64_t>(Wide{ sum } * reciprocal >> ReciprocalBits);
    return static_cast<std::int32_t>(std::clamp(quotient, -maximum, maximum));
  }

  // The square root, rounded down. Floating point gives it or a neighbour, however it rounds.
  static std::int32_t FindRoot(std::int64_t number)
  {
    auto root = static_cast<std::int64_t>(std::sqrt(static_cast<double>(number)));
    while (root * root > number)
    {
      --root;
    }
    while ((root + 1) * (root + 1) <= number)
    {
      ++root;
    }
    return static_cast<std::int32_t>(std::min(root, MaximumFactor));
  }

  alignas(32) std::array<std::array<std::int32_t, Size>, Size + 1> Factors;
  std::array<std::int64_t, Size> Reciprocals;
};

} // namespace isosurface

#endif
