// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_HeightFit_h
#define isosurface_HeightFit_h

#include "Coding/Prediction/LeastSquares.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// A linear function of `Size` inputs that is fitted by least squares to pairs of inputs and a
/// target. Older pairs count less and less. All is integers, see LeastSquares.
template <int Size>
class LinearFit
{
public:
  static constexpr int WeightBits = LeastSquares<Size>::WeightBits;
  static constexpr int FineBits = 4; ///< predictions have these fractional bits

  /// Sets the first weights, in units of 2^-WeightBits. They count as much as inputs whose squares
  /// add up to `certainty`.
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

  /// The prediction, in units of 2^-FineBits.
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

  /// Adds sums of products of inputs, [i][j] with j <= i; the row `target` has those with the target.
  /// Earlier sums lose 2^-decay of their weight.
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

  /// Computes the weights from all that was added; they stay as they are if that cannot be solved.
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
 * slowly (half in 700 vertices), one of the first ten that forgets quickly (half in 40). They are
 * weighed by the inverse squares of their recent mean squared errors. After: X. Wu, E. U. Barthel
 * and W. Zhang, "Piecewise 2D autoregression for predictive image coding", ICIP 1998; B. Meyer and
 * P. Tischer, "TMW: a new method for lossless image compression", PCS 1997 (mixing of predictions).
 */
class HeightFit
{
public:
  static constexpr int NumberOfInputs = 24;

  /// weights: the first ones, in units of 2^-LinearFit::WeightBits.
  explicit HeightFit(const std::array<std::int32_t, NumberOfInputs>& weights)
  {
    constexpr std::int64_t certainty = 3000000;
    this->Slow.Begin(weights.data(), certainty);
    this->Quick.Begin(weights.data(), certainty);
  }

  /// The inputs of the next prediction, to be set.
  std::int16_t* GetInputs() { return this->Inputs.data(); }

  /// The height that the inputs predict.
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
    constexpr int shift = 16 + LinearFit<1>::FineBits;
    return static_cast<std::int32_t>((sum + (1 << (shift - 1))) >> shift);
  }

  /// Learns the height that belongs to the last inputs.
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
  std::array<std::int64_t, 2> Errors{ 1 << 16, 1 << 16 }; ///< recent mean squares
  /// Inputs to learn from, by input; the last row has the heights.
  alignas(32) std::array<std::array<std::int16_t, BatchSize>, NumberOfInputs + 1> Batch{};
  std::size_t InBatch = 0;
  bool Odd = false; ///< the number of batches; after every second one Slow is solved, which is dear
};

} // namespace isosurface

#endif
