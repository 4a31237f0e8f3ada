// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ResidualCoder_h
#define isosurface_ResidualCoder_h

#include "Coding/EntropyCoding/AdaptiveModels.h"
#include "Coding/TrainedModels/TrainedTables.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace isosurface
{

/// The level of a magnitude: the binary logarithm of (magnitude + 1), in eighths; 0 for 0, at most
/// 503. In this room levels are always such logarithms, never levels of detail.
inline int MeasureMagnitude(std::uint64_t magnitude)
{
  constexpr std::uint64_t maximum = (std::uint64_t(1) << 62) - 1;
  const std::uint64_t number = (magnitude < maximum ? magnitude : maximum) + 1;
  const int zeros = __builtin_clzll(number);
  // Eight, and the three digits after the first one.
  return 8 * (62 - zeros) + static_cast<int>(number << zeros >> 60);
}

/// What is known before a magnitude is coded.
struct ResidualContext
{
  int Level = 0; ///< the expected magnitude, as MeasureMagnitude gives it
  /// Side information: further contexts, below 128 each. Not mixed, only the first one counts.
  std::array<std::uint32_t, 5> Sides{};
};

/// The expected level from those coded around (x, y): levels[0] is the one that was coded last at
/// the place itself, in the slice before.
inline int FindExpectedLevel(const std::uint16_t* levels, std::ptrdiff_t rowStride)
{
  return (4 * (levels[-1] + levels[-rowStride] + levels[0]) +
           2 * (levels[-rowStride - 1] + levels[-rowStride + 1]) + 8) >>
    4;
}

/**
 * A guess of a number within bounds. Numbers on both sides of the guess become magnitudes by their
 * distance, as long as the bounds allow; then only one side is left:
 *
 *   distance   0   1   1   2   2  ...  room + 1   room + 2  ...
 *   side           A   B   A   B       the side with more room
 *   magnitude  0   1   2   3   4       2 room + 1  ...
 */
struct BoundedGuess
{
  std::int64_t Guess;
  std::int64_t Minimum;
  std::int64_t Maximum;
  bool LowerFirst; ///< whether side A is below the guess

  std::int64_t GetRoom() const
  {
    return std::min(this->Guess - this->Minimum, this->Maximum - this->Guess);
  }

  std::uint64_t ToMagnitude(std::int64_t number) const
  {
    const std::int64_t room = this->GetRoom();
    const std::int64_t difference = number - this->Guess;
    const std::int64_t distance = difference < 0 ? -difference : difference;
    if (distance > room)
    {
      return static_cast<std::uint64_t>(distance + room);
    }
    const std::uint64_t first =
      SpreadBit((difference < 0) == this->LowerFirst) & (distance != 0 ? 1 : 0);
    return 2 * static_cast<std::uint64_t>(distance) - first;
  }

  /// Magnitudes that no encoder writes give the number of the maximum magnitude.
  std::int64_t FromMagnitude(std::uint64_t magnitude) const
  {
    const std::int64_t room = this->GetRoom();
    const auto limit = static_cast<std::uint64_t>(this->Maximum - this->Minimum);
    const auto rank = static_cast<std::int64_t>(std::min(magnitude, limit));
    if (rank > 2 * room)
    {
      const bool below = this->Guess - this->Minimum > this->Maximum - this->Guess;
      return below ? this->Guess - (rank - room) : this->Guess + (rank - room);
    }
    const std::int64_t distance = (rank + 1) / 2;
    const auto below = static_cast<std::int64_t>(SpreadBit(((rank & 1) != 0) == this->LowerFirst));
    return this->Guess + ((distance ^ below) - below);
  }
};

/// Signed numbers as magnitudes, and back: 0, -1, 1, -2 ... as 0, 1, 2, 3 ...
inline std::uint64_t MakeMagnitude(std::int64_t number)
{
  return (static_cast<std::uint64_t>(number) << 1) ^ static_cast<std::uint64_t>(number >> 63);
}
inline std::uint64_t MakeDifference(std::uint64_t magnitude)
{
  return (magnitude >> 1) ^ (0 - (magnitude & 1));
}

/// The decisions that lead to a symbol, from node 1 on. A tree fills one cache line.
struct alignas(64) SymbolTree
{
  std::array<AdaptiveBit, NumberOfSymbols> Nodes;
};

/**
 * Trees by side and half the level. A block needs few of them, so each is made when it is first used,
 * a copy of the prior of its level: to make all would take longer than to code a small block. Node 0
 * tells which block a tree was made for.
 */
class SideTrees
{
public:
  static constexpr std::size_t NumberOfSides = 128;
  static constexpr std::size_t NumberOfTables = 5;

  /// By half the level.
  explicit SideTrees(std::vector<SymbolTree> priors = {})
    : Priors(std::move(priors))
  {
    for (std::vector<SymbolTree>& table : this->Tables)
    {
      table.resize(this->Priors.size() * NumberOfSides);
    }
  }

  /// Forgets all trees.
  void Reset() { ++this->Block; }

  AdaptiveBit* GetNodes(std::size_t table, std::size_t halfLevel, std::uint32_t side)
  {
    SymbolTree& tree = this->Tables[table][halfLevel * NumberOfSides + side];
    if (tree.Nodes[0].State != this->Block)
    {
      tree = this->Priors[halfLevel];
      tree.Nodes[0].State = this->Block;
    }
    return tree.Nodes.data();
  }

private:
  std::vector<SymbolTree> Priors;
  std::array<std::vector<SymbolTree>, NumberOfTables> Tables;
  std::uint32_t Block = 0;
};

/// Probabilities of magnitudes.
struct ResidualModel
{
  static constexpr int NumberOfLevels = 32;
  static constexpr int NumberOfMixerSets = 4;

  /// Not mixed; begins with the shares of CrossingSymbols.
  ResidualModel();
  /// Mixed; levels, mixers: see TrainedTables.h.
  ResidualModel(
    const std::array<std::int8_t, 512>& levels, const std::array<std::int16_t, 512>& mixers);

  /// Forgets what was learnt since it was like `fresh`.
  void Reset(const ResidualModel& fresh);

  /// If not mixed: by level and the first side (8 of them).
  std::vector<AdaptiveSymbol> Symbols;
  /// If mixed: nodes of the binary tree of symbols.
  std::vector<SymbolTree> ByLevel;
  SideTrees BySide;
  std::vector<LogisticMixer> Mixers;
  std::array<AdaptiveBit, 64> Escape;
};

/**
 * Codes magnitudes (0 to 2^64 - 1) whose size is roughly known. The low bits of a magnitude are as
 * good as random, and coded as such. A symbol gives the range of the rest:
 *
 *   symbol       0 .. 7   8   9   10  11  12  13  14  15
 *   rest from    0 .. 7   8   10  12  16  20  28  44  76 (Exp-Golomb)
 *   extra bits   0        1   1   2   2   3   4   5
 */
template <typename Coder, bool Mixed>
class ResidualCoder
{
public:
  ResidualCoder(Coder& coder, ResidualModel& model)
    : Output(coder)
    , Model(model)
  {
  }

  std::uint64_t Code(std::uint64_t magnitude, const ResidualContext& context)
  {
    Coder coder = this->Output;
    magnitude = this->Code(coder, magnitude, context);
    this->Output = coder;
    return magnitude;
  }

  /// Codes by a copy of the coder.
  std::uint64_t Code(Coder& coder, std::uint64_t magnitude, const ResidualContext& context)
  {
    const int low = std::max(0, (context.Level >> 3) - 2);
    std::uint64_t rest = magnitude >> low;
    const int level = FindLevelClass(context.Level, low);
    int symbol = 0;
    if constexpr (Coder::Encodes)
    {
      symbol = FindSymbol(rest);
    }
    symbol = Mixed ? this->CodeSymbolMixed(coder, symbol, level, context)
                   : this->CodeSymbol(coder, symbol, level, context);
    if (symbol == Last)
    {
      this->Output = coder;
      rest = this->CodeEscape(rest - First[Last]) + First[Last];
      coder = this->Output;
      return rest << low | CodeDigits(coder, magnitude, low);
    }
    // The extra bits and the low bits at once.
    const std::uint64_t base = std::uint64_t{ First[symbol] } << low;
    return base + CodeDigits(coder, magnitude - base, Bits[symbol] + low);
  }

private:
  static constexpr int Last = NumberOfSymbols - 1;
  static constexpr std::uint8_t First[NumberOfSymbols] = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16,
    20, 28, 44, 76 };
  static constexpr std::uint8_t Bits[NumberOfSymbols] = { 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 2, 2, 3, 4,
    5, 0 };

  static int FindSymbol(std::uint64_t rest)
  {
    if (rest < 8)
    {
      return static_cast<int>(rest);
    }
    int symbol = 8;
    while (symbol < Last && rest >= First[symbol + 1])
    {
      ++symbol;
    }
    return symbol;
  }

  // The table for a level: one for each quarter of an octave, apart for each number of low bits
  // from 0 to 5. More low bits are as 5.
  static int FindLevelClass(int level, int low)
  {
    return low == 0 ? std::min(level / 2, 11) : 12 + (level & 7) / 2 + 4 * std::min(low - 1, 4);
  }

  int CodeSymbol(Coder& coder, int symbol, int level, const ResidualContext& context)
  {
    AdaptiveSymbol& model =
      this->Model.Symbols[static_cast<std::size_t>(level) * 8 + (context.Sides[0] & 7)];
    symbol = coder.CodeSymbol(symbol, model.Cumulative.data());
    model.Update(symbol);
    return symbol;
  }

  int CodeSymbolMixed(Coder& coder, int symbol, int level, const ResidualContext& context)
  {
    constexpr std::size_t nodes = NumberOfSymbols;
    AdaptiveBit* tables[SideTrees::NumberOfTables + 1];
    tables[0] = this->Model.ByLevel[static_cast<std::size_t>(level)].Nodes.data();
    for (std::size_t n = 0; n < SideTrees::NumberOfTables; ++n)
    {
      tables[n + 1] =
        this->Model.BySide.GetNodes(n, static_cast<std::size_t>(level / 2), context.Sides[n]);
    }
    const std::size_t mixers = static_cast<std::size_t>(std::min(level / 5, 3)) * nodes;
    std::size_t node = 1;
    for (int bit = 3; bit >= 0; --bit)
    {
      const bool one =
        CodeMixed(coder, tables, node, std::make_index_sequence<SideTrees::NumberOfTables + 1>(),
          this->Model.Mixers[mixers + node], (symbol >> bit & 1) != 0, 250, 1);
      node = 2 * node + (one ? 1 : 0);
    }
    return static_cast<int>(node - nodes);
  }

  // Exp-Golomb: the number of binary digits of excess + 1 as adaptive bits, then the digits. Rarely
  // needed, so it is not compiled into the loops.
  __attribute__((noinline)) std::uint64_t CodeEscape(std::uint64_t excess)
  {
    int digits = 0;
    if constexpr (Coder::Encodes)
    {
      digits = 63 - __builtin_clzll(excess + 1);
    }
    int count = 0;
    while (count < 63 &&
      CodeAdaptive(
        this->Output, this->Model.Escape[static_cast<std::size_t>(count)], count < digits, 255))
    {
      ++count;
    }
    return ((std::uint64_t(1) << count) | CodeDigits(this->Output, excess + 1, count)) - 1;
  }

  // The lowest `count` binary digits of a number.
  static std::uint64_t CodeDigits(Coder& coder, std::uint64_t number, int count)
  {
    std::uint64_t bits = 0;
    while (count > 0)
    {
      const int size = std::min(count, MaximumUniformBits);
      count -= size;
      const auto digits = static_cast<std::uint32_t>(number >> count & ((1u << size) - 1));
      bits = bits << size | coder.CodeUniform(digits, size);
    }
    return bits;
  }

  Coder& Output;
  ResidualModel& Model;
};

} // namespace isosurface

#endif
