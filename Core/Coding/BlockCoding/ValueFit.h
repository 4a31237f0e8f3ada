// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ValueFit_h
#define isosurface_ValueFit_h

#include "Coding/BlockCoding/ValueDomain.h"
#include "Coding/BlockCoding/ValueModel.h"
#include "Coding/Prediction/HeightFit.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace isosurface
{

/// Predicts a height by HeightFit, from the inputs of ValueFilter and eight more. Used by the
/// profile compact.
class ValueFit
{
public:
  explicit ValueFit(ValueModel& model)
    : Fit(MakeFirstWeights(model))
  {
  }

  void BeginSlice() {}
  void BeginRow() {}

  std::int32_t Predict(const ValueSurroundings& around, int x)
  {
    const std::int16_t* p = around.Rows[0] + x;
    const std::int16_t* z = around.Rows[1] + x;
    constexpr std::ptrdiff_t row = ValueSurroundings::RowStride;
    const std::int32_t side = around.GetSide();
    // Typical heights of vertices that are not decoded yet, from their signs: at a given vertex,
    // and at the next one along an axis.
    const auto at = [&around](const SignRow& signs, int place)
    { return static_cast<std::int16_t>(signs.Get(place) ? around.Typical : -around.Typical); };
    const auto other = [&around, side](unsigned axis)
    { return static_cast<std::int16_t>((around.Crossed >> axis & 1) != 0 ? -side : side); };
    const SignSlice& above = *around.Above;
    const std::array<std::int16_t, HeightFit::NumberOfInputs> inputs = { p[-1], p[-row], z[0],
      p[-row - 1], p[-row + 1], z[-1], z[1], z[-row], z[row], z[-row + 1], z[row - 1], p[-2],
      p[-2 * row], around.Rows[2][x], static_cast<std::int16_t>(side),
      static_cast<std::int16_t>(around.GetLeading()), z[-row - 1], z[row + 1], other(0), other(1),
      other(2), at(around.Signs->At(around.Y + 1), x + 1), at(above.At(around.Y), x + 1),
      at(above.At(around.Y + 1), x) };
    std::copy(inputs.begin(), inputs.end(), this->Fit.GetInputs());
    return this->Fit.Predict();
  }

  /// Learns the height at the vertex that was predicted last.
  void Learn(std::int32_t, std::int32_t height)
  {
    // A height at the bound says little about those around it.
    if (std::abs(height) < ValueDomain::MaximumHeight)
    {
      this->Fit.Learn(height);
    }
  }

private:
  // The first weights of the filter in the units of the fit.
  static std::array<std::int32_t, HeightFit::NumberOfInputs> MakeFirstWeights(
    const ValueModel& model)
  {
    std::array<std::int32_t, HeightFit::NumberOfInputs> weights{};
    for (std::size_t n = 0; n < model.Weights.size(); ++n)
    {
      weights[ValueModel::InputOrder[n]] = model.Weights[n] >> (25 - LinearFit<1>::WeightBits);
    }
    return weights;
  }

  HeightFit Fit;
};

} // namespace isosurface

#endif
