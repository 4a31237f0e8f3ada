// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WideMixer_h
#define isosurface_WideMixer_h

#include "Coding/EntropyCoding/AdaptiveModels.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// Squash for a number that is known to be within -2047 .. 2047: without a call and without
/// clamping.
inline std::uint32_t GetSquashed(int x)
{
  return Tables.Squash[static_cast<std::size_t>(x + 2048)];
}

/// A LogisticMixer of 32 inputs, which need not be stretched probabilities.
struct WideMixer
{
  static constexpr std::size_t Size = 32;
  using Values = std::array<std::int16_t, Size>;

  alignas(32) Values Weights; ///< in units of 2^-14

  /// The stretched probability of a 1. Inputs lie within -2047 .. 2047.
  int Mix(const Values& inputs) const
  {
    int sum = 0;
    for (std::size_t n = 0; n < Size; ++n)
    {
      sum += inputs[n] * this->Weights[n];
    }
    sum >>= 14;
    return sum < -2047 ? -2047 : sum > 2047 ? 2047 : sum;
  }

  /// Learns from the bit that was coded; stretched: what Mix returned.
  void Update(const Values& inputs, int stretched, bool bit)
  {
    const int error = ((bit ? 65535 : 0) - static_cast<int>(GetSquashed(stretched))) >> 1;
    for (std::size_t n = 0; n < Size; ++n)
    {
      const int weight = this->Weights[n] + ((inputs[n] * error + 0x4000) >> 15);
      this->Weights[n] = static_cast<std::int16_t>(weight < -32767 ? -32767
          : weight > 32767                                         ? 32767
                                                                   : weight);
    }
  }
};

} // namespace isosurface

#endif
