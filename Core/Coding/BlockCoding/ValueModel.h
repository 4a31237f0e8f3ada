// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ValueModel_h
#define isosurface_ValueModel_h

#include "Coding/BlockCoding/ResidualCoder.h"
#include "Coding/Prediction/SignRows.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// What is learnt about the values of a block.
struct ValueModel
{
  static constexpr int NumberOfTaps = 16;
  /// The filter's inputs stand in an order in which few loads fetch them: input n is number
  /// InputOrder[n] of the format.
  static constexpr std::array<std::size_t, NumberOfTaps> InputOrder = { 3, 1, 4, 12, 5, 2, 6, 13, 0,
    11, 7, 9, 10, 8, 14, 15 };

  explicit ValueModel(bool isUsed);

  /// Forgets what was learnt since it was like `fresh`.
  void Reset(const ValueModel& fresh);

  ResidualModel Residuals;
  alignas(64) std::array<std::int32_t, NumberOfTaps> Weights; ///< in units of 2^-25, by InputOrder
  std::int32_t MeanHeight = 700 << 6; ///< the mean magnitude of heights that were coded, times 64
  int MeanLevel = 24 * 16;            ///< of coded magnitudes (MeasureMagnitude), times 16
};

/// What is known around the vertex whose value is predicted.
struct ValueSurroundings
{
  static constexpr std::ptrdiff_t RowStride = 80; ///< of heights

  /// Heights of the row at x = 0: in this slice, the one before, and the one before that.
  std::array<std::int16_t*, 3> Rows{};
  const SignSlice* Signs = nullptr; ///< of this slice
  const SignSlice* Above = nullptr; ///< of the next slice; of this one if it is the last

  bool Inside = false;      ///< the vertex
  unsigned Crossed = 0;     ///< bits of the crossed edges that begin at it: x, y, z
  std::int32_t Typical = 0; ///< the mean magnitude of heights

  /// A typical height on the side of the vertex.
  std::int32_t GetSide() const { return this->Inside ? this->Typical : -this->Typical; }
  /// An input of predictions: the more crossed edges begin at the vertex, the further on the other
  /// side.
  std::int32_t GetLeading() const
  {
    return -__builtin_popcount(this->Crossed) * this->GetSide() * 3 / 10;
  }
};

} // namespace isosurface

#endif
