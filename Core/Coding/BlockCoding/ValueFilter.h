// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ValueFilter_h
#define isosurface_ValueFilter_h

#include "Coding/BlockCoding/ValueModel.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace isosurface
{

/**
 * Predicts a height from 14 decoded ones, and the signs, by a linear filter that learns from each
 * value (normalised least mean squares: B. Widrow and M. E. Hoff, "Adaptive switching circuits",
 * 1960; J. Nagumo and A. Noda, 1967).
 */
class ValueFilter
{
public:
  explicit ValueFilter(ValueModel& model)
    : Model(model)
  {
  }

  void BeginSlice()
  {
    const std::int64_t mean = std::max(this->Model.MeanHeight >> 6, 8);
    const std::int64_t power = mean * mean * 3 / 2;
    // 16777: a learning rate of 0.0005 in the unit of weights, 2^-25.
    this->Rate = static_cast<std::int32_t>((std::int64_t(16777) << 16) / power);
  }

  void BeginRow()
  {
    // What they learn in one row is too little to overflow from these bounds.
    constexpr std::int32_t maximum = 1 << 27;
    for (std::int32_t& weight : this->Model.Weights)
    {
      weight = std::clamp(weight, -maximum, maximum);
    }
    this->ShortenWeights();
  }

  std::int32_t Predict(const ValueSurroundings& around, int x)
  {
    const std::int16_t* p = around.Rows[0] + x;
    const std::int16_t* z = around.Rows[1] + x;
    const std::int16_t second = around.Rows[2][x];
    const std::int32_t side = around.GetSide();
    const std::int32_t leading = around.GetLeading();
    constexpr std::ptrdiff_t row = ValueSurroundings::RowStride;
#if defined(__SSE2__)
    // Assembled in registers: one load of what several stores just wrote would stall. The heights
    // before on the row are loaded one by one for the same reason, the last one at last.
    const auto four = [](const std::int16_t* first, std::int16_t last)
    { return _mm_insert_epi16(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(first)), last, 3); };
    const auto two = [](const std::int16_t* first)
    { return _mm_cvtsi32_si128(Load<std::int32_t>(first)); };
    __m128i rest = _mm_slli_si128(_mm_unpacklo_epi32(two(z - row), two(z + row - 1)), 4);
    rest = _mm_insert_epi16(_mm_insert_epi16(rest, side, 6), leading, 7);
    rest = _mm_insert_epi16(_mm_insert_epi16(rest, p[-2], 1), p[-1], 0);
    const __m128i halves[2] = {
      _mm_unpacklo_epi64(four(p - row - 1, p[-2 * row]), four(z - 1, second)), rest
    };
    __m128i sums = _mm_setzero_si128();
    for (int half = 0; half < 2; ++half)
    {
      _mm_store_si128(reinterpret_cast<__m128i*>(this->Inputs.data()) + half, halves[half]);
      const __m128i weights =
        _mm_load_si128(reinterpret_cast<const __m128i*>(this->ShortWeights.data()) + half);
      sums = _mm_add_epi32(sums, _mm_madd_epi16(halves[half], weights));
    }
    const __m128i pairs = _mm_add_epi32(sums, _mm_shuffle_epi32(sums, 0x4e));
    return _mm_cvtsi128_si32(_mm_add_epi32(pairs, _mm_shuffle_epi32(pairs, 0xb1))) >> 13;
#else
    this->Inputs = { p[-row - 1], p[-row], p[-row + 1], p[-2 * row], z[-1], z[0], z[1], second,
      p[-1], p[-2], z[-row], z[-row + 1], z[row - 1], z[row], static_cast<std::int16_t>(side),
      static_cast<std::int16_t>(leading) };
    std::int32_t sum = 0;
    for (std::size_t n = 0; n < Taps; ++n)
    {
      sum += this->Inputs[n] * this->ShortWeights[n];
    }
    return sum >> 13;
#endif
  }

  /// Learns the height at the vertex that was predicted last.
  void Learn(std::int32_t predicted, std::int32_t height)
  {
    const std::int64_t error = std::clamp(height - predicted, -8191, 8191);
    const auto step =
      static_cast<std::int32_t>(std::clamp<std::int64_t>(error * this->Rate >> 8, -32767, 32767));
    this->Adapt(static_cast<std::int16_t>(step));
  }

private:
  static constexpr std::size_t Taps = ValueModel::NumberOfTaps;
  static constexpr int ShortShift = 12; ///< from Weights to ShortWeights

  template <typename Word>
  static Word Load(const std::int16_t* values)
  {
    Word word;
    std::memcpy(&word, values, sizeof(word));
    return word;
  }

  // Moves weights by inputs * step.
  void Adapt(std::int16_t step)
  {
#if defined(__SSE2__)
    const __m128i factor = _mm_set1_epi16(step);
    auto* weights = reinterpret_cast<__m128i*>(this->Model.Weights.data());
    for (int half = 0; half < 2; ++half)
    {
      const __m128i inputs =
        _mm_load_si128(reinterpret_cast<const __m128i*>(this->Inputs.data()) + half);
      const __m128i low = _mm_mullo_epi16(inputs, factor);
      const __m128i high = _mm_mulhi_epi16(inputs, factor);
      const auto move = [](__m128i& weight, __m128i product)
      {
        weight = _mm_add_epi32(weight, _mm_srai_epi32(product, 8));
        return _mm_srai_epi32(weight, ShortShift);
      };
      const __m128i first = move(weights[2 * half], _mm_unpacklo_epi16(low, high));
      const __m128i second = move(weights[2 * half + 1], _mm_unpackhi_epi16(low, high));
      _mm_store_si128(reinterpret_cast<__m128i*>(this->ShortWeights.data()) + half,
        _mm_packs_epi32(first, second));
    }
#else
    for (std::size_t n = 0; n < Taps; ++n)
    {
      this->Model.Weights[n] += this->Inputs[n] * step >> 8;
    }
    this->ShortenWeights();
#endif
  }

  void ShortenWeights()
  {
    for (std::size_t n = 0; n < Taps; ++n)
    {
      this->ShortWeights[n] =
        static_cast<std::int16_t>(std::clamp(this->Model.Weights[n] >> ShortShift, -32768, 32767));
    }
  }

  ValueModel& Model;
  std::int32_t Rate = 0; ///< of learning, over the mean square of inputs; in units of 2^-41
  alignas(32) std::array<std::int16_t, Taps> Inputs{};
  alignas(32) std::array<std::int16_t, Taps> ShortWeights{}; ///< those that predict
};

} // namespace isosurface

#endif
