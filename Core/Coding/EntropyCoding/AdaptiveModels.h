// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AdaptiveModels_h
#define isosurface_AdaptiveModels_h

#include "Coding/EntropyCoding/RangeCoder.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#if defined(__SSE2__)
#  include <emmintrin.h>
#endif

namespace isosurface
{

// Probabilities that learn. All arithmetic is of integers, so that encoders and decoders on every
// machine have the same probabilities.

/// The logistic function: 65536 / (1 + exp(-x / 256)), with x brought into -2047 .. 2047. The x of
/// a probability is called stretched: its logit, in units of 1/256.
std::uint32_t Squash(int x);

/// Tables of functions.
struct ModelTables
{
  std::array<std::uint16_t, 4096> Squash; ///< at x + 2048
  std::array<std::int16_t, 4096> Stretch; ///< the inverse, of a probability in units of 2^-12
  std::array<std::uint16_t, 1024> Rates;  ///< 65536 / (n + 1.6)
  /// For each symbol the shares that AdaptiveSymbol moves towards.
  alignas(16) std::array<std::array<std::int16_t, NumberOfSymbols>, NumberOfSymbols> Targets;
  ModelTables();
};
extern const ModelTables Tables;

/// The probability of a 1 (the upper 22 bits) and the number of its updates (the lower 10): it
/// learns fast at first.
struct AdaptiveBit
{
  std::uint32_t State = 1u << 31;

  std::uint32_t GetProbability() const
  {
    const std::uint32_t probability = this->State >> 16;
    return probability < 24 ? 24 : probability > 65512 ? 65512 : probability;
  }
  /// `limit` is the maximum of the count, so that the rate is at least about 1 / limit.
  void Update(bool bit, std::uint32_t limit)
  {
    const std::uint32_t count = this->State & 1023;
    const auto probability = static_cast<std::int64_t>(this->State >> 10);
    const std::int64_t target = bit ? (1 << 22) - 1 : 0;
    const std::int64_t next = probability + ((target - probability) * Tables.Rates[count] >> 16);
    this->State = static_cast<std::uint32_t>(next) << 10 | (count < limit ? count + 1 : count);
  }
};

/// A probability that begins with 16 * `stretched` (see Squash), as after `count` updates.
inline AdaptiveBit MakeAdaptiveBit(std::int8_t stretched, std::uint32_t count)
{
  AdaptiveBit bit;
  bit.State = Squash(stretched * 16) << 16 | count;
  return bit;
}

/// Codes a bit by one adaptive probability.
template <typename Coder>
inline bool CodeAdaptive(Coder& coder, AdaptiveBit& model, bool bit, std::uint32_t limit)
{
  bit = coder.CodeBit(bit, model.GetProbability());
  model.Update(bit, limit);
  return bit;
}

/// The shares of 16 symbols, as RangeEncoder::CodeSymbol takes them.
struct AdaptiveSymbol
{
  /// An update moves all shares towards the symbol by 2^-Rate; none falls below 2^-12.
  static constexpr int Rate = 5;

  alignas(16) std::array<std::int16_t, NumberOfSymbols> Cumulative;

  AdaptiveSymbol()
  {
    for (int n = 0; n < NumberOfSymbols; ++n)
    {
      this->Cumulative[static_cast<std::size_t>(n)] =
        static_cast<std::int16_t>((1 << FrequencyBits) / NumberOfSymbols * n);
    }
  }
  void Update(int symbol)
  {
    const std::int16_t* targets = Tables.Targets[static_cast<std::size_t>(symbol)].data();
#if defined(__SSE2__)
    auto* shares = reinterpret_cast<__m128i*>(this->Cumulative.data());
    for (int half = 0; half < 2; ++half)
    {
      const __m128i now = _mm_load_si128(shares + half);
      const __m128i target = _mm_load_si128(reinterpret_cast<const __m128i*>(targets) + half);
      const __m128i step = _mm_srai_epi16(_mm_sub_epi16(target, now), Rate);
      _mm_store_si128(shares + half, _mm_add_epi16(now, step));
    }
#else
    for (std::size_t n = 0; n < std::size_t{ NumberOfSymbols }; ++n)
    {
      const int now = this->Cumulative[n];
      this->Cumulative[n] = static_cast<std::int16_t>(now + ((targets[n] - now) >> Rate));
    }
#endif
  }
};

/// Eight stretched probabilities to mix. The last one is constant, the others are 0 unless set.
struct MixerInputs
{
  static constexpr int Size = 8;
  static constexpr std::int16_t Last = 256;

#if defined(__SSE2__)
  // Assembled in a register: one load of what several stores just wrote would stall.
  __m128i Values = _mm_set_epi16(Last, 0, 0, 0, 0, 0, 0, 0);
  template <int N>
  void Set(std::int16_t value)
  {
    this->Values = _mm_insert_epi16(this->Values, value, N);
  }
#else
  std::array<std::int16_t, Size> Values{ 0, 0, 0, 0, 0, 0, 0, Last };
  template <int N>
  void Set(std::int16_t value)
  {
    this->Values[N] = value;
  }
#endif
};

/// Logistic mixing of up to 8 probabilities: M. V. Mahoney, "Adaptive weighing of context models
/// for lossless data compression", Florida Tech. CS-2005-16, 2005; with weights of 16 bits.
struct LogisticMixer
{
  static constexpr int Size = MixerInputs::Size;
  alignas(16) std::array<std::int16_t, Size> Weights; ///< in units of 2^-14

  /// The mixed probability of a 1, in units of 2^-16.
  std::uint32_t Mix(const MixerInputs& inputs) const
  {
#if defined(__SSE2__)
    const __m128i products = _mm_madd_epi16(
      inputs.Values, _mm_load_si128(reinterpret_cast<const __m128i*>(this->Weights.data())));
    const __m128i pairs = _mm_add_epi32(products, _mm_shuffle_epi32(products, 0x4e));
    const __m128i sums = _mm_add_epi32(pairs, _mm_shuffle_epi32(pairs, 0xb1));
    // Saturated in 16 bits, of which four are shifted out: x is clamped to -2048 .. 2047, and Squash is
    // the same at -2048 as at -2047.
    const __m128i fine = _mm_srai_epi32(sums, 10);
    const __m128i above = _mm_xor_si128(_mm_packs_epi32(fine, fine), _mm_set1_epi16(-32768));
    return Tables.Squash[static_cast<std::size_t>(_mm_extract_epi16(_mm_srli_epi16(above, 4), 0))];
#else
    int sum = 0;
    for (int n = 0; n < Size; ++n)
    {
      sum +=
        inputs.Values[static_cast<std::size_t>(n)] * this->Weights[static_cast<std::size_t>(n)];
    }
    return Tables.Squash[static_cast<std::size_t>(std::clamp(sum >> 14, -2047, 2047) + 2048)];
#endif
  }

  /// Learns from the bit that was coded: weights move by inputs * error * 2^-rate.
  void Update(const MixerInputs& inputs, std::uint32_t probability, bool bit, int rate)
  {
    const int error = ((bit ? 65535 : 0) - static_cast<int>(probability)) >> rate;
#if defined(__SSE2__)
    const __m128i x = inputs.Values;
    const __m128i e = _mm_set1_epi16(static_cast<std::int16_t>(error));
    const __m128i rounding = _mm_srli_epi16(_mm_mullo_epi16(x, e), 15);
    const __m128i step = _mm_add_epi16(_mm_mulhi_epi16(x, e), rounding);
    auto* weights = reinterpret_cast<__m128i*>(this->Weights.data());
    _mm_store_si128(weights, _mm_adds_epi16(_mm_load_si128(weights), step));
#else
    for (int n = 0; n < Size; ++n)
    {
      const int weight = this->Weights[static_cast<std::size_t>(n)] +
        ((inputs.Values[static_cast<std::size_t>(n)] * error + 0x8000) >> 16);
      this->Weights[static_cast<std::size_t>(n)] =
        static_cast<std::int16_t>(weight < -32768 ? -32768
            : weight > 32767 ? 32767
                             : weight);
    }
#endif
  }
};

#if defined(__GNUC__)
/// Does AdaptiveBit::Update for number `n` of each of `Count` (at most 8) different tables.
template <std::size_t Count>
inline void UpdateAll(AdaptiveBit* const* tables, std::size_t n, bool bit, std::uint32_t limit)
{
  constexpr std::size_t lanes = 8;
  static_assert(Count <= lanes, "one lane a model");
  using Unsigned = std::uint32_t __attribute__((vector_size(4 * lanes)));
  using Signed = std::int32_t __attribute__((vector_size(4 * lanes)));
  using Floats = float __attribute__((vector_size(4 * lanes)));
  Unsigned states{};
  for (std::size_t table = 0; table < Count; ++table)
  {
    states[table] = tables[table][n].State;
  }
  // As signed numbers, which vectors convert and compare at once.
  const auto counts = reinterpret_cast<Signed>(states & 1023);
  // Tables.Rates: rounded down, this division is as exact.
  const Floats divisors = __builtin_convertvector(counts, Floats) * 10.0f + 16.0f;
  const auto rates = __builtin_convertvector(655360.0f / divisors, Signed);
  // The product with the rate has up to 38 bits.
  const Signed steps = (bit ? (1 << 22) - 1 : 0) - reinterpret_cast<Signed>(states >> 10);
  const Signed high = (steps >> 16) * rates;
  const Unsigned low =
    (reinterpret_cast<Unsigned>(steps) & 0xffff) * reinterpret_cast<Unsigned>(rates) >> 16;
  states += (reinterpret_cast<Unsigned>(high) + low) << 10;
  states -= reinterpret_cast<Unsigned>(counts < static_cast<std::int32_t>(limit));
  for (std::size_t table = 0; table < Count; ++table)
  {
    tables[table][n].State = states[table];
  }
}
#else
template <std::size_t Count>
inline void UpdateAll(AdaptiveBit* const* tables, std::size_t n, bool bit, std::uint32_t limit)
{
  for (std::size_t table = 0; table < Count; ++table)
  {
    tables[table][n].Update(bit, limit);
  }
}
#endif

/// Codes a bit by mixing number `n` of each of some tables (at most 7), all different, and a constant.
template <typename Coder, std::size_t... N>
inline bool CodeMixed(Coder& coder, AdaptiveBit* const* tables, std::size_t n,
  std::index_sequence<N...>, LogisticMixer& mixer, bool bit, std::uint32_t limit, int rate)
{
  static_assert(sizeof...(N) < LogisticMixer::Size, "one input is constant");
  MixerInputs inputs;
  (inputs.Set<N>(Tables.Stretch[tables[N][n].State >> 20]), ...);
  const std::uint32_t probability = mixer.Mix(inputs);
  bit = coder.CodeBit(bit, probability);
  mixer.Update(inputs, probability, bit, rate);
  UpdateAll<sizeof...(N)>(tables, n, bit, limit);
  return bit;
}

} // namespace isosurface

#endif
