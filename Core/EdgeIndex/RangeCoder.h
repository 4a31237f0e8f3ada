// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RangeCoder_h
#define isosurface_RangeCoder_h

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Probabilities of bits are in units of 2^-16, cumulative frequencies of symbols of 2^-15.
constexpr int ProbabilityBits = 16;
constexpr int FrequencyBits = 15;
constexpr int NumberOfSymbols = 16;
/// Most bits of one call of CodeUniform.
constexpr int MostUniformBits = 16;

/**
 * Range coding: G. N. N. Martin, "Range encoding: an algorithm for removing redundancy from a
 * digitised message", 1979; with an interval of 64 bits that is renewed 32 bits at a time, so that
 * the branch for it is seldom taken. A carry runs back into the bytes that are already there.
 *
 * Encoder and decoder have the same functions, so that a model is written once for both: each
 * returns what was coded; the decoder ignores its first argument. All arithmetic is of integers.
 */
class RangeEncoder
{
public:
  static constexpr bool Encodes = true;

  /// Appends to `bytes`, which must outlive the encoder.
  explicit RangeEncoder(std::vector<std::uint8_t>& bytes)
    : Bytes(bytes)
    , First(bytes.size())
  {
  }

  /// A bit that is 1 with the probability `one` / 2^16, 0 < one < 2^16.
  bool CodeBit(bool bit, std::uint32_t one)
  {
    const std::uint64_t bound = (this->Range >> ProbabilityBits) * one;
    if (bit)
    {
      this->Range = bound;
    }
    else
    {
      this->Advance(bound);
      this->Range -= bound;
    }
    this->Normalize();
    return bit;
  }

  /// A number of `bits` bits (0 to 16), all equally likely.
  std::uint32_t CodeUniform(std::uint32_t number, int bits)
  {
    this->Range >>= bits;
    this->Advance(this->Range * number);
    this->Normalize();
    return number;
  }

  /// One of 16 symbols; cumulative[s] to cumulative[s + 1] of 2^15 is the share of symbol s.
  int CodeSymbol(int symbol, const std::uint16_t* cumulative)
  {
    const std::uint64_t unit = this->Range >> FrequencyBits;
    this->Advance(unit * cumulative[symbol]);
    this->Range = unit * static_cast<std::uint64_t>(cumulative[symbol + 1] - cumulative[symbol]);
    this->Normalize();
    return symbol;
  }

  /// Writes what is left: the shortest number within the interval, at most 8 bytes.
  void Finish()
  {
    for (int size = 1; size <= 8; ++size)
    {
      const std::uint64_t mask = size == 8 ? 0 : ~std::uint64_t(0) >> (8 * size);
      const std::uint64_t up = mask - (this->Low & mask);
      const std::uint64_t step = (this->Low & mask) == 0 ? 0 : up + 1;
      if (step < this->Range)
      {
        this->Advance(step);
        for (int n = 0; n < size; ++n)
        {
          this->Bytes.push_back(static_cast<std::uint8_t>(this->Low >> (56 - 8 * n)));
        }
        return;
      }
    }
  }

private:
  void Advance(std::uint64_t step)
  {
    this->Low += step;
    if (this->Low < step)
    {
      for (std::size_t n = this->Bytes.size(); n > this->First && ++this->Bytes[--n] == 0;)
      {
      }
    }
  }
  void Normalize()
  {
    if (this->Range >> 32 == 0)
    {
      const std::uint8_t word[4] = { static_cast<std::uint8_t>(this->Low >> 56),
        static_cast<std::uint8_t>(this->Low >> 48), static_cast<std::uint8_t>(this->Low >> 40),
        static_cast<std::uint8_t>(this->Low >> 32) };
      this->Bytes.insert(this->Bytes.end(), word, word + 4);
      this->Low <<= 32;
      this->Range <<= 32;
    }
  }

  std::vector<std::uint8_t>& Bytes;
  std::size_t First;
  std::uint64_t Low = 0;
  std::uint64_t Range = ~std::uint64_t(0);
};

/// See RangeEncoder. Whatever the bytes, every call returns; bytes behind the end are zeros.
class RangeDecoder
{
public:
  static constexpr bool Encodes = false;

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
    const bool bit = this->Code < bound;
    this->Code -= bit ? 0 : bound;
    this->Range = bit ? bound : this->Range - bound;
    this->Normalize();
    return bit;
  }

  std::uint32_t CodeUniform(std::uint32_t, int bits)
  {
    this->Range >>= bits;
    const std::uint64_t last = (std::uint64_t(1) << bits) - 1;
    std::uint64_t number = this->Code / this->Range;
    number = number > last ? last : number; // of bytes that no encoder wrote
    this->Code -= number * this->Range;
    this->Normalize();
    return static_cast<std::uint32_t>(number);
  }

  int CodeSymbol(int, const std::uint16_t* cumulative)
  {
    const std::uint64_t unit = this->Range >> FrequencyBits;
    int symbol = 0;
    for (int n = 1; n < NumberOfSymbols; ++n)
    {
      symbol += this->Code >= unit * cumulative[n] ? 1 : 0;
    }
    this->Code -= unit * cumulative[symbol];
    this->Range = unit * static_cast<std::uint64_t>(cumulative[symbol + 1] - cumulative[symbol]);
    this->Normalize();
    return symbol;
  }

  /// Whether more was decoded than the encoder wrote.
  bool IsExhausted() const { return this->Missing > 8; }

  /// Whether bytes are left over that the encoder would not have written.
  bool HasMore() const { return this->Next != this->End; }

private:
  std::uint32_t ReadWord()
  {
    std::uint32_t word = 0;
    for (int n = 0; n < 4; ++n)
    {
      word = word << 8 | (this->Next != this->End ? *this->Next++ : this->ReadMissing());
    }
    return word;
  }
  std::uint8_t ReadMissing()
  {
    this->Missing += this->Missing <= 8 ? 1 : 0;
    return 0;
  }
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
  int Missing = 0;
};

} // namespace isosurface

#endif
