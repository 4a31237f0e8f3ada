// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AdaptiveModels_h
#define isosurface_AdaptiveModels_h

#include "EdgeIndex/RangeCoder.h"

#include <array>
#include <cstdint>

#if defined(__SSE2__)
#  include <emmintrin.h>
#endif

namespace isosurface
{

// Probabilities that learn. All arithmetic is of integers, so that an encoder and a decoder on
// whatever machine have the same ones.

/// The logistic function: 65536 / (1 + exp(-x / 256)) for x from -2047 to 2047, within 11 .. 65525.
std::uint32_t Squash(int x);

struct ModelTables
{
  std::array<std::uint16_t, 4096> Squash; ///< at x + 2048
  std::array<std::int16_t, 4096> Stretch; ///< the inverse: of a probability in units of 2^-12
  std::array<std::uint16_t, 1024> Rates;  ///< 65536 / (n + 1.6)
  ModelTables();
};
extern const ModelTables Tables;

/// The probability of a 1, as 22 bits, and how often it was updated, as 10: fast at first.
struct AdaptiveBit
{
  std::uint32_t State = 1u << 31;

  std::uint32_t GetProbability() const
  {
    const std::uint32_t probability = this->State >> 16;
    return probability < 24 ? 24 : probability > 65512 ? 65512 : probability;
  }
  /// `most` bounds the count, so that 1 / most is the least rate.
  void Update(bool bit, std::uint32_t most)
  {
    const std::uint32_t count = this->State & 1023;
    const auto probability = static_cast<std::int64_t>(this->State >> 10);
    const std::int64_t target = bit ? (1 << 22) - 1 : 0;
    const std::int64_t next = probability + ((target - probability) * Tables.Rates[count] >> 16);
    this->State = static_cast<std::uint32_t>(next) << 10 | (count < most ? count + 1 : count);
  }
};

/// Codes a bit by one adaptive probability.
template <typename Coder>
inline bool CodeAdaptive(Coder& coder, AdaptiveBit& model, bool bit, std::uint32_t most)
{
  bit = coder.CodeBit(bit, model.GetProbability());
  model.Update(bit, most);
  return bit;
}

/// The shares of 16 symbols.
struct AdaptiveSymbol
{
  std::array<std::uint16_t, NumberOfSymbols + 1> Cumulative;

  AdaptiveSymbol()
  {
    for (int n = 0; n <= NumberOfSymbols; ++n)
    {
      this->Cumulative[static_cast<std::size_t>(n)] =
        static_cast<std::uint16_t>((1 << FrequencyBits) / NumberOfSymbols * n);
    }
  }
  /// Moves all shares towards the symbol by 2^-rate; none falls below 2^-12.
  void Update(int symbol, int rate)
  {
    constexpr int least = 8;
    constexpr int most = (1 << FrequencyBits) - least * NumberOfSymbols;
    for (int n = 1; n < NumberOfSymbols; ++n)
    {
      const int target = least * n + (n > symbol ? most : 0);
      const int now = this->Cumulative[static_cast<std::size_t>(n)];
      this->Cumulative[static_cast<std::size_t>(n)] =
        static_cast<std::uint16_t>(now + ((target - now) >> rate));
    }
  }
};

/**
 * Logistic mixing of up to 8 probabilities: M. V. Mahoney, "Adaptive weighing of context models
 * for lossless data compression", Florida Tech. CS-2005-16, 2005; with weights of 16 bits.
 */
struct LogisticMixer
{
  static constexpr int Size = 8;
  alignas(16) std::array<std::int16_t, Size> Weights; ///< in units of 2^-14

  /// The probability of a 1 from stretched ones, in units of 2^-16.
  std::uint32_t Mix(const std::int16_t* inputs) const
  {
#if defined(__SSE2__)
    const __m128i products =
      _mm_madd_epi16(_mm_load_si128(reinterpret_cast<const __m128i*>(inputs)),
        _mm_load_si128(reinterpret_cast<const __m128i*>(this->Weights.data())));
    const __m128i pairs = _mm_add_epi32(products, _mm_shuffle_epi32(products, 0x4e));
    const int sum = _mm_cvtsi128_si32(_mm_add_epi32(pairs, _mm_shuffle_epi32(pairs, 0xb1)));
#else
    int sum = 0;
    for (int n = 0; n < Size; ++n)
    {
      sum += inputs[n] * this->Weights[static_cast<std::size_t>(n)];
    }
#endif
    const int x = sum >> 14;
    return Tables.Squash[static_cast<std::size_t>((x < -2047     ? -2047
                                                      : x > 2047 ? 2047
                                                                 : x) +
      2048)];
  }

  /// Learns from the bit that came: weights move by inputs * error * 2^-rate.
  void Update(const std::int16_t* inputs, std::uint32_t probability, bool bit, int rate)
  {
    const int error = ((bit ? 65535 : 0) - static_cast<int>(probability)) >> rate;
#if defined(__SSE2__)
    const __m128i x = _mm_load_si128(reinterpret_cast<const __m128i*>(inputs));
    const __m128i e = _mm_set1_epi16(static_cast<std::int16_t>(error));
    const __m128i rounding = _mm_srli_epi16(_mm_mullo_epi16(x, e), 15);
    const __m128i step = _mm_add_epi16(_mm_mulhi_epi16(x, e), rounding);
    auto* weights = reinterpret_cast<__m128i*>(this->Weights.data());
    _mm_store_si128(weights, _mm_adds_epi16(_mm_load_si128(weights), step));
#else
    for (int n = 0; n < Size; ++n)
    {
      const int weight =
        this->Weights[static_cast<std::size_t>(n)] + ((inputs[n] * error + 0x8000) >> 16);
      this->Weights[static_cast<std::size_t>(n)] =
        static_cast<std::int16_t>(weight < -32768 ? -32768
            : weight > 32767                      ? 32767
                                                  : weight);
    }
#endif
  }
};

/**
 * Codes a bit by mixing up to 7 adaptive probabilities and a constant.
 *
 * models: the probability in each context; `Count` of them.
 */
template <int Count, typename Coder>
inline bool CodeMixed(Coder& coder, AdaptiveBit* const* models, LogisticMixer& mixer, bool bit,
  std::uint32_t most, int rate)
{
  static_assert(Count < LogisticMixer::Size, "one input is constant");
  alignas(16) std::int16_t inputs[LogisticMixer::Size] = { 0, 0, 0, 0, 0, 0, 0, 256 };
  for (int n = 0; n < Count; ++n)
  {
    inputs[n] = Tables.Stretch[models[n]->State >> 20];
  }
  const std::uint32_t probability = mixer.Mix(inputs);
  bit = coder.CodeBit(bit, probability);
  mixer.Update(inputs, probability, bit, rate);
  for (int n = 0; n < Count; ++n)
  {
    models[n]->Update(bit, most);
  }
  return bit;
}

} // namespace isosurface

#endif
