// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RangeCoder_h
#define isosurface_RangeCoder_h

#include <cstddef>
#include <cstdint>
#include <vector>

#if defined(__SSE2__)
#  include <emmintrin.h>
#endif

namespace isosurface
{

constexpr int ProbabilityBits = 16; ///< probabilities of bits are in units of 2^-16
constexpr int FrequencyBits = 15;   ///< cumulative shares of symbols are in units of 2^-15
constexpr int NumberOfSymbols = 16;
constexpr int MaximumUniformBits = 16; ///< of one call of CodeUniform

/// The share of a symbol; see RangeEncoder::CodeSymbol.
inline std::uint64_t GetShare(const std::int16_t* cumulative, int symbol)
{
  const int above = symbol + 1 < NumberOfSymbols ? cumulative[symbol + 1] : 1 << FrequencyBits;
  return static_cast<std::uint64_t>(above - cumulative[symbol]);
}

/// All bits set, or none. The compiler does not see where they come from: of a decision that is coded,
/// it would make a branch, and the processor would guess it wrong as often as not.
inline std::uint64_t SpreadBit(bool bit)
{
  std::uint64_t mask = 0 - static_cast<std::uint64_t>(bit);
#if defined(__GNUC__)
  asm("" : "+r"(mask));
#endif
  return mask;
}

/// The last symbol whose cumulative share is not above `share`.
inline int FindSymbol(const std::int16_t* cumulative, std::int16_t share)
{
#if defined(__SSE2__)
  const __m128i wanted = _mm_set1_epi16(share);
  const auto* shares = reinterpret_cast<const __m128i*>(cumulative);
  const __m128i low = _mm_cmpgt_epi16(_mm_loadu_si128(shares), wanted);
  const __m128i high = _mm_cmpgt_epi16(_mm_loadu_si128(shares + 1), wanted);
  // The first symbol above it; bit 16 is set in case there is none.
  const int above = _mm_movemask_epi8(_mm_packs_epi16(low, high)) | 1 << NumberOfSymbols;
  return __builtin_ctz(static_cast<unsigned>(above)) - 1;
#else
  int symbol = 0;
  for (int n = 1; n < NumberOfSymbols; ++n)
  {
    symbol += cumulative[n] <= share ? 1 : 0;
  }
  return symbol;
#endif
}

/**
 * Encodes decisions of known probabilities: G. N. N. Martin, "Range encoding: an algorithm for
 * removing redundancy from a digitised message", 1979. The interval has 64 bits and is renormalized
 * 32 bits at a time, so that the branch for it is rarely taken. A carry is added to the bytes that
 * are already written.
 *
 * Encoder and decoder have the same functions, so that a model is written once for both. Each
 * function returns what was coded; the decoder ignores its first argument. All arithmetic is of
 * integers, so that every machine gets the same bytes. What is rarely needed is not inline: the
 * coders compile the rest into each of their loops.
 *
 * A coder is a few numbers, which a loop copies, and back at its end: the copy stays in registers, since
 * nothing that is called gets its address.
 */
class RangeEncoder
{
public:
  static constexpr bool Encodes = true;

  /// Appends to `bytes`, which must outlive the encoder.
  explicit RangeEncoder(std::vector<std::uint8_t>& bytes)
    : Bytes(&bytes)
    , First(bytes.size())
  {
  }

  /// Codes a bit that is 1 with the probability one / 2^16, 0 < one < 2^16.
  bool CodeBit(bool bit, std::uint32_t one)
  {
    const std::uint64_t bound = (this->Range >> ProbabilityBits) * one;
    const std::uint64_t mask = SpreadBit(bit);
    this->Advance(bound & ~mask);
    this->Range = (bound & mask) | ((this->Range - bound) & ~mask);
    this->Normalize();
    return bit;
  }

  /// Codes a number of 0 to 16 bits, all numbers being equally likely.
  std::uint32_t CodeUniform(std::uint32_t number, int bits)
  {
    this->Range >>= bits;
    this->Advance(this->Range * number);
    this->Normalize();
    return number;
  }

  /// Codes one of 16 symbols. The share of symbol s is from cumulative[s] to cumulative[s + 1], in
  /// units of 2^-15; cumulative[0] is 0, and the last symbol's share ends at 2^15.
  int CodeSymbol(int symbol, const std::int16_t* cumulative)
  {
    const std::uint64_t unit = this->Range >> FrequencyBits;
    this->Advance(unit * static_cast<std::uint64_t>(cumulative[symbol]));
    this->Range = unit * GetShare(cumulative, symbol);
    this->Normalize();
    return symbol;
  }

  /// Writes the shortest number within the interval, at most 8 bytes. Nothing may follow.
  void Finish();

private:
  void Advance(std::uint64_t step)
  {
    this->Low += step;
    if (this->Low < step)
    {
      Carry(*this->Bytes, this->First);
    }
  }
  void Normalize()
  {
    if (this->Range >> 32 == 0)
    {
      AppendWord(*this->Bytes, static_cast<std::uint32_t>(this->Low >> 32));
      this->Low <<= 32;
      this->Range <<= 32;
    }
  }
  static void Carry(std::vector<std::uint8_t>& bytes, std::size_t first);
  static void AppendWord(std::vector<std::uint8_t>& bytes, std::uint32_t word);

  std::vector<std::uint8_t>* Bytes;
  std::size_t First;
  std::uint64_t Low = 0;
  std::uint64_t Range = ~std::uint64_t(0);
};

/// Decodes what RangeEncoder encoded. Every call returns, whatever the bytes; bytes beyond the end
/// are read as zeros.
class RangeDecoder
{
public:
  static constexpr bool Encodes = false;

  /// The bytes must outlive the decoder.
  RangeDecoder(const std::uint8_t* bytes, std::size_t size)
    : Next(bytes)
    , End(bytes + size)
  {
    this->Code = static_cast<std::uint64_t>(this->ReadWord()) << 32;
    this->Code |= this->ReadWord();
  }

  bool CodeBit(bool, std::uint32_t one)
  {
    const std::uint64_t bound = (this->Range >> ProbabilityBits) * one;
    const std::uint64_t mask = SpreadBit(this->Code < bound);
    this->Code -= bound & ~mask;
    this->Range = (bound & mask) | ((this->Range - bound) & ~mask);
    this->Normalize();
    return (mask & 1) != 0;
  }

  std::uint32_t CodeUniform(std::uint32_t, int bits)
  {
    this->Range >>= bits;
    const std::uint64_t last = (std::uint64_t(1) << bits) - 1;
    std::uint64_t number = this->Code / this->Range;
    number = number > last ? last : number; // only for bytes that no encoder wrote
    this->Code -= number * this->Range;
    this->Normalize();
    return static_cast<std::uint32_t>(number);
  }

  int CodeSymbol(int, const std::int16_t* cumulative)
  {
    const std::uint64_t unit = this->Range >> FrequencyBits;
    const std::uint64_t share = this->Code / unit;
    constexpr std::uint64_t maximum = (1 << FrequencyBits) - 1;
    const int symbol =
      FindSymbol(cumulative, static_cast<std::int16_t>(share < maximum ? share : maximum));
    this->Code -= unit * static_cast<std::uint64_t>(cumulative[symbol]);
    this->Range = unit * GetShare(cumulative, symbol);
    this->Normalize();
    return symbol;
  }

  /// Whether the decoder read further than the encoder wrote.
  bool IsExhausted() const { return this->Missing > 8; }

  /// Whether bytes are left that the encoder would not have written.
  bool HasMore() const { return this->Next != this->End; }

private:
  std::uint32_t ReadWord()
  {
    if (this->End - this->Next < 4)
    {
      RangeDecoder copy = *this;
      const std::uint32_t word = copy.ReadLastWord();
      *this = copy;
      return word;
    }
    const std::uint8_t* bytes = this->Next;
    this->Next += 4;
    return static_cast<std::uint32_t>(bytes[0]) << 24 | static_cast<std::uint32_t>(bytes[1]) << 16 |
      static_cast<std::uint32_t>(bytes[2]) << 8 | bytes[3];
  }
  std::uint32_t ReadLastWord();
  void Normalize()
  {
    if (this->Range >> 32 == 0)
    {
      this->Code = this->Code << 32 | this->ReadWord();
      this->Range <<= 32;
    }
  }

  const std::uint8_t* Next;
  const std::uint8_t* End;
  std::uint64_t Code = 0;
  std::uint64_t Range = ~std::uint64_t(0);
  int Missing = 0; ///< bytes that were read beyond the end, at most 9
};

} // namespace isosurface

#endif
