// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_HeightFit_h
#define isosurface_HeightFit_h

#include "BlockCoding/LeastSquares.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace isosurface
{

/**
 * A linear function of `Size` inputs that is fitted to pairs of inputs and a target by least
 * squares; older pairs count less and less. In integers throughout (see LeastSquares).
 */
template <int Size>
class LinearFit
{
public:
  static constexpr int WeightBits = LeastSquares<Size>::WeightBits;
  static constexpr int FineBits = 4; ///< of what is predicted

  /// Begins with weights (in units of 2^-WeightBits), which count as much as inputs of that square.
  void Begin(const std::int32_t* weights, std::int64_t certainty)
  {
    for (auto& row : this->Products)
    {
      row.fill(0);
    }
    for (std::size_t n = 0; n < Size; ++n)
    {
      this->Weights[n] = weights[n];
      this->Products[n][n] = certainty;
      this->Products[Size][n] = certainty * weights[n] >> WeightBits;
    }
  }

  /// In units of 2^-FineBits of those of the inputs.
  std::int32_t Predict(const std::int16_t* inputs) const
  {
    std::int64_t sum = 0;
    for (std::size_t n = 0; n < Size; ++n)
    {
      sum += std::int64_t{ inputs[n] } * this->Weights[n];
    }
    constexpr std::int64_t maximum = (1 << 17) - 1;
    return static_cast<std::int32_t>(
      std::clamp<std::int64_t>(sum >> (WeightBits - FineBits), -maximum, maximum));
  }

  /// Adds sums of products of the inputs, [i][j] with j <= i, of which the row `target` has those
  /// with the target; what came before counts 2^-decay less.
  template <typename Sums>
  void Add(const Sums& sums, std::size_t target, int decay)
  {
    for (std::size_t i = 0; i <= Size; ++i)
    {
      const auto& added = sums[i == Size ? target : i];
      for (std::size_t j = 0; j < std::min<std::size_t>(i + 1, Size); ++j)
      {
        this->Products[i][j] += added[j] - (this->Products[i][j] >> decay);
      }
    }
    this->TargetSquare += sums[target][target] - (this->TargetSquare >> decay);
  }

  /// Makes the weights of what was added.
  void Solve()
  {
    LeastSquares<Size> equations;
    if (equations.Factor(this->Products, this->TargetSquare))
    {
      equations.Substitute(Size, this->Weights);
    }
  }

private:
  std::array<std::int32_t, Size> Weights{};
  typename LeastSquares<Size>::Equations Products{};
  std::int64_t TargetSquare = 0;
};

/**
 * Predicts heights from heights around by two linear functions: one of all inputs that forgets
 * slowly (half of it in 700 vertices), one of the first ten that forgets quickly (in 40). They are
 * mixed by the squares of the errors that they made of late. After: X. Wu, E. U. Barthel and W.
 * Zhang, "Piecewise 2D autoregression for predictive image coding", ICIP 1998; B. Meyer and P.
 * Tischer, "TMW: a new method for lossless image compression", PCS 1997 (mixing of predictions).
 */
class HeightFit
{
public:
  static constexpr int NumberOfInputs = 24;

  /// Begins with weights in units of 2^-LinearFit::WeightBits.
  explicit HeightFit(const std::array<std::int32_t, NumberOfInputs>& weights)
  {
    constexpr std::int64_t certainty = 3000000;
    this->Slow.Begin(weights.data(), certainty);
    this->Quick.Begin(weights.data(), certainty);
  }

  /// Where the inputs of the next vertex go.
  std::int16_t* GetInputs() { return this->Inputs.data(); }

  /// The height that follows from the inputs.
  std::int32_t Predict()
  {
    this->Predictions = { this->Slow.Predict(this->Inputs.data()),
      this->Quick.Predict(this->Inputs.data()) };
    const std::int64_t maximum = std::max(this->Errors[0], this->Errors[1]) | 1;
    const int down = std::max(0, 64 - __builtin_clzll(static_cast<std::uint64_t>(maximum)) - 18);
    const std::int64_t first = (this->Errors[0] >> down) + 1;
    const std::int64_t second = (this->Errors[1] >> down) + 1;
    const std::int64_t share = (second * second << 16) / (first * first + second * second);
    const std::int64_t sum =
      this->Predictions[0] * share + this->Predictions[1] * ((1 << 16) - share);
    constexpr int down2 = 16 + LinearFit<1>::FineBits;
    return static_cast<std::int32_t>((sum + (1 << (down2 - 1))) >> down2);
  }

  /// The height that came for the last inputs.
  void Learn(std::int32_t height)
  {
    for (std::size_t n = 0; n < 2; ++n)
    {
      const std::int64_t error =
        this->Predictions[n] - height * (std::int64_t{ 1 } << LinearFit<1>::FineBits);
      const std::int64_t square = std::min(error * error, std::int64_t{ 1 } << 34);
      this->Errors[n] += (square - this->Errors[n]) >> 4;
    }
    for (std::size_t n = 0; n < NumberOfInputs; ++n)
    {
      this->Batch[n][this->InBatch] = this->Inputs[n];
    }
    this->Batch[NumberOfInputs][this->InBatch] = static_cast<std::int16_t>(height);
    if (++this->InBatch == BatchSize)
    {
      this->InBatch = 0;
      this->LearnBatch();
    }
  }

private:
  static constexpr std::size_t BatchSize = 8;
  static constexpr int NumberOfQuickInputs = 10;
  static constexpr int SlowDecay = 7;
  static constexpr int QuickDecay = 3;

  void LearnBatch()
  {
    std::array<std::array<std::int32_t, NumberOfInputs + 1>, NumberOfInputs + 1> sums;
    for (std::size_t i = 0; i <= NumberOfInputs; ++i)
    {
      for (std::size_t j = 0; j <= i; ++j)
      {
        std::int32_t sum = 0;
        for (std::size_t k = 0; k < BatchSize; ++k)
        {
          sum += this->Batch[i][k] * this->Batch[j][k];
        }
        sums[i][j] = sum;
      }
    }
    this->Quick.Add(sums, NumberOfInputs, QuickDecay);
    this->Quick.Solve();
    this->Slow.Add(sums, NumberOfInputs, SlowDecay);
    this->Odd = !this->Odd;
    if (!this->Odd)
    {
      this->Slow.Solve();
    }
  }

  LinearFit<NumberOfInputs> Slow;
  LinearFit<NumberOfQuickInputs> Quick;
  alignas(32) std::array<std::int16_t, NumberOfInputs> Inputs{};
  std::array<std::int32_t, 2> Predictions{};
  std::array<std::int64_t, 2> Errors{ 1 << 16, 1 << 16 }; ///< mean squares of late
  /// Inputs that are to be learnt, and in the last row what came of them.
  alignas(32) std::array<std::array<std::int16_t, BatchSize>, NumberOfInputs + 1> Batch{};
  std::size_t InBatch = 0;
  bool Odd = false; ///< the number of batches
};

} // namespace isosurface

#endif
