// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SignCoder_h
#define isosurface_SignCoder_h

#include "Coding/EntropyCoding/AdaptiveModels.h"
#include "Coding/Prediction/SignRows.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace isosurface
{

/// The decoded rows around the current one: Y is the row before in the slice, Z the same row in the
/// slice before, M and P are one row before and after Z; doubled letters are two rows or slices away.
struct SignRowsAround
{
  SignRow Y, YY, Z, ZM, ZP, ZMM, ZPP, ZZ, ZZM, ZZP;
};

/// Numbers by `own`: the signs of the two vertices before, at x - 2 (bit 0) and x - 1.
using BySignsBefore = std::array<std::uint32_t, 4>;

/// left: if the sign at x - 1 is 1. left2: if that at x - 2 is another one.
constexpr BySignsBefore MakeChanges(std::uint32_t left, std::uint32_t left2)
{
  return { 0, left2, left ^ left2, left };
}

/**
 * The contexts of the signs of eight vertices of a row, found at once in vectors. All signs of a
 * context are relative to that of the left vertex, which is not decoded yet for most of the eight. So
 * they are found for each of the four cases of the two signs before.
 */
class SignContexts
{
public:
  static constexpr int Size = 8;
  static constexpr int NumberOfNeighbors = 12;
  static constexpr int HashBits = 14;
  static constexpr std::size_t NumberOfHashed = 5;

  /// Of one vertex: places in tables.
  struct Indices
  {
    std::array<std::uint32_t, NumberOfHashed> Hashed;
    std::uint32_t Near;  ///< by the 12 nearest neighbours
    std::uint32_t Mixer; ///< below 64
  };

  /// Forgets what was found.
  void Clear() { this->Begin = -Size; }

  bool Has(int x) const { return static_cast<unsigned>(x - this->Begin) < Size; }

  /// Finds the contexts of the vertices x .. x + 7; all of them only if `mixed`.
  void Find(const SignRowsAround& rows, int x, bool mixed)
  {
    this->Begin = x;
    constexpr Vector steps = { 0, 1, 2, 3, 4, 5, 6, 7 };
    // The first five bits of a lane are the signs at x - 2 .. x + 2.
    const Vector y = rows.Y.GetBits(x - 2) >> steps;
    const Vector z = rows.Z.GetBits(x - 2) >> steps;
    const Vector zm = rows.ZM.GetBits(x - 2) >> steps;
    const Vector zp = rows.ZP.GetBits(x - 2) >> steps;
    const Vector near = (y >> 1 & 7) | (z << 2 & 7 << 3) | (zm << 5 & 7 << 6) | (zp << 8 & 7 << 9);
    Store(near, this->Near);
    if (!mixed)
    {
      return;
    }
    const Vector yy = rows.YY.GetBits(x - 2) >> steps;
    const Vector zz = rows.ZZ.GetBits(x - 2) >> steps;
    const Vector zmm = rows.ZMM.GetBits(x - 2) >> steps;
    const Vector zpp = rows.ZPP.GetBits(x - 2) >> steps;
    const Vector zzm = rows.ZZM.GetBits(x - 2) >> steps;
    const Vector zzp = rows.ZZP.GetBits(x - 2) >> steps;
    const Vector core = (y >> 2 & 3) | (z & 3 << 2) | (zp << 2 & 1 << 4);
    // Bit 0 is for the sign at x - 2.
    const Vector out = (yy >> 1 & 1 << 1) | (zz & 1 << 2) | (y << 3 & 1 << 3) | (y & 1 << 4) |
      (z << 5 & 1 << 5) | (z << 2 & 1 << 6);
    const Vector wide = (zmm << 18 & 1 << 20) | (zpp << 19 & 1 << 21) | (yy << 21 & 1 << 22) |
      (yy << 20 & 1 << 23) | (zz << 23 & 1 << 24) | (zz << 22 & 1 << 25);
    const Vector behind =
      (zz << 11 & 7 << 12) | (zzm << 13 & 1 << 15) | (zzp << 14 & 1 << 16) | (yy << 16 & 7 << 17);
    const Vector across = (zmm << 11 & 7 << 12) | (zpp << 14 & 7 << 15) | (yy << 17 & 7 << 18);
    const Vector keys[NumberOfKeys] = { near | out << 12, near | out << 12 | wide | 1u << 30,
      near | behind | 1u << 31, core | out << 5 | across | 3u << 30 };
    for (std::size_t own = 0; own < this->Slots.size(); ++own)
    {
      for (std::size_t n = 0; n < NumberOfKeys; ++n)
      {
        const Vector product = (keys[n] ^ KeyChanges[n][own]) * 0x9E3779B1u;
        Store((product ^ product >> 15) >> 3 & ((1u << HashBits) - 1), this->Slots[own][n]);
      }
    }
    Store(core, this->Core);
    Store(
      out >> 1 | (yy & 31) << 6 | (zz & 31) << 11 | (zmm & 31) << 16 | (zpp & 31) << 21, this->Far);
  }

  std::uint32_t GetNear(int x, std::uint32_t own) const
  {
    return this->Near[this->At(x)] ^ NearChanges[own];
  }
  Indices GetIndices(int x, std::uint32_t own) const
  {
    const std::size_t at = this->At(x);
    const auto& slots = this->Slots[own];
    const std::uint32_t near = this->GetNear(x, own);
    const std::uint32_t mixer = this->Core[at] ^ CoreChanges[own];
    const std::uint32_t far = this->Far[at] ^ FarChanges[own];
    return { { slots[0][at], slots[1][at], Count(near) | Count(far) << 4 | (mixer & 31) << 9,
               slots[2][at], slots[3][at] },
      near, mixer };
  }

private:
  static constexpr std::size_t NumberOfKeys = 4; ///< to be hashed
  // What the signs before change in keys: all signs, and the one at x - 2.
  static constexpr std::uint32_t AllNear = (1u << NumberOfNeighbors) - 1;
  static constexpr std::uint32_t AllOut = 0x7eu;
  static constexpr BySignsBefore NearChanges = MakeChanges(AllNear, 0);
  static constexpr BySignsBefore CoreChanges = MakeChanges(31, 32);
  static constexpr BySignsBefore FarChanges = MakeChanges((1u << 26) - 1, 1u << 26);
  static constexpr std::array<BySignsBefore, NumberOfKeys> KeyChanges = {
    MakeChanges(AllNear | AllOut << 12, 1u << 12),
    MakeChanges(AllNear | AllOut << 12 | 63u << 20, 1u << 12),
    MakeChanges((1u << 20) - 1, 1u << 20),
    MakeChanges(31 | AllOut << 5 | 1023u << 12, 1u << 5),
  };

  using Lanes = std::array<std::uint32_t, Size>;
  using Vector = std::uint32_t __attribute__((vector_size(4 * Size)));

  std::size_t At(int x) const { return static_cast<std::size_t>(x - this->Begin); }

  static std::uint32_t Count(std::uint32_t bits)
  {
    return static_cast<std::uint32_t>(__builtin_popcount(bits));
  }

  static void Store(const Vector& lanes, Lanes& numbers)
  {
    std::memcpy(numbers.data(), &lanes, sizeof(lanes));
  }

  int Begin = -Size;
  alignas(32) Lanes Near;
  alignas(32) Lanes Core;                                           ///< the nearest of all
  alignas(32) Lanes Far;                                            ///< signs that are only counted
  alignas(32) std::array<std::array<Lanes, NumberOfKeys>, 4> Slots; ///< hashed keys, by `own`
};

/// The probabilities that a run of quiet vertices, whose decoded neighbours all have one sign, has that
/// sign throughout; by the length of the run.
using QuietSigns = std::array<AdaptiveBit, 8>;

/// What is learnt about the signs of a block.
struct SignModel
{
  static constexpr std::size_t NumberOfMixers = 128;

  explicit SignModel(bool mixed);

  /// Forgets what was learnt since it was like `fresh`.
  void Reset(const SignModel& fresh);

  /// By 12 decoded neighbours, relative to the sign of the left one; a second table for the first
  /// slice.
  std::array<AdaptiveBit, std::size_t(2) << SignContexts::NumberOfNeighbors> Near;
  QuietSigns Quiet;
  /// By further neighbours; only if mixed. One table after the other.
  std::vector<AdaptiveBit> Hashed;
  std::array<LogisticMixer, NumberOfMixers> Mixers;
};

/// Codes the sign of a vertex in contexts of decoded signs. After: G. Taubin, "BLIC: bi-level
/// isosurface compression", IEEE Visualization 2002; here with 13 neighbours and, if mixed, five wider
/// contexts.
template <typename Coder, bool Mixed>
class ContextSigns
{
public:
  explicit ContextSigns(SignModel& model)
    : Known(model)
  {
  }

  void BeginRow(bool isInFirstSlice)
  {
    const std::size_t table = isInFirstSlice ? 1 : 0;
    this->Near = this->Known.Near.data() + (table << SignContexts::NumberOfNeighbors);
    this->Mixers = this->Known.Mixers.data() + table * (SignModel::NumberOfMixers / 2);
    this->Contexts.Clear();
  }

  /// Codes the sign of vertex x. own: the signs at x - 2 (bit 0) and x - 1.
  bool CodeVertex(Coder& coder, bool bit, std::uint32_t own, const SignRowsAround& rows, int x)
  {
    const bool flipped = own >> 1 != 0;
    if (!this->Contexts.Has(x))
    {
      this->Contexts.Find(rows, x, Mixed);
    }
    if constexpr (Mixed)
    {
      return this->CodeWithHashed(coder, bit != flipped, this->Contexts.GetIndices(x, own)) !=
        flipped;
    }
    else
    {
      AdaptiveBit& near = this->Near[this->Contexts.GetNear(x, own)];
      return CodeAdaptive(coder, near, bit != flipped, 255) != flipped;
    }
  }

private:
  // Codes a bit, relative to the left sign, with the nearest context and the five hashed ones.
  bool CodeWithHashed(Coder& coder, bool bit, const SignContexts::Indices& indices)
  {
    constexpr std::size_t count = SignContexts::NumberOfHashed;
    AdaptiveBit* models[count + 1] = { this->Near + indices.Near };
    for (std::size_t n = 0; n < count; ++n)
    {
      models[n + 1] = this->Known.Hashed.data() + (n << SignContexts::HashBits) + indices.Hashed[n];
    }
    return CodeMixed(coder, models, 0, std::make_index_sequence<count + 1>(),
      this->Mixers[indices.Mixer], bit, 800, 1);
  }

  SignModel& Known;
  AdaptiveBit* Near = nullptr; ///< the table of the slice
  LogisticMixer* Mixers = nullptr;
  SignContexts Contexts;
};

/**
 * Codes the signs of the vertices of a block, slice after slice, each in the order of rows. Crossed
 * edges, active cells and connectivity follow from them. Long runs of equal signs are coded as a
 * whole, other vertices by ContextSigns.
 */
template <typename Coder, bool Mixed>
class SignCoder
{
public:
  SignCoder(Coder& coder, SignModel& model, int sizeX, int sizeY)
    : Vertices(model)
    , Quiet(model.Quiet)
    , Output(coder)
    , SizeX(sizeX)
    , SizeY(sizeY)
  {
  }

  /**
   * Codes `slice`: its bits are given when encoding, set when decoding; margins are set in both
   * cases. below, below2: the slice before and the one before that, null if there is none.
   */
  void CodeSlice(SignSlice& slice, const SignSlice* below, const SignSlice* below2)
  {
    const SignRow blank;
    for (int y = -2; y < 0; ++y)
    {
      slice.At(y) = below ? below->At(0) : blank;
    }
    for (int y = 0; y < this->SizeY; ++y)
    {
      this->FindRows(slice, below, below2, y);
      SignRow row = slice.At(y);
      this->Vertices.BeginRow(!below);
      this->CodeRow(row);
      row.SpreadEnds(this->SizeX);
      slice.At(y) = row;
    }
    slice.At(this->SizeY) = slice.At(this->SizeY - 1);
    slice.At(this->SizeY + 1) = slice.At(this->SizeY - 1);
  }

private:
  void FindRows(const SignSlice& slice, const SignSlice* below, const SignSlice* below2, int y)
  {
    SignRowsAround& rows = this->Around;
    rows.Y = slice.At(y - 1);
    rows.YY = slice.At(y - 2);
    if (!below)
    {
      rows.Z = rows.ZM = rows.ZP = rows.ZMM = rows.ZPP = rows.ZZ = rows.ZZM = rows.ZZP = rows.Y;
      return;
    }
    rows.Z = below->At(y);
    rows.ZM = below->At(y - 1);
    rows.ZP = below->At(y + 1);
    rows.ZMM = below->At(y - 2);
    rows.ZPP = below->At(std::min(y + 2, this->SizeY + 1));
    const SignSlice& second = below2 ? *below2 : *below;
    rows.ZZ = second.At(y);
    rows.ZZM = second.At(y - 1);
    rows.ZZP = second.At(y + 1);
  }

  // By the signs of the two vertices before: the vertices whose neighbours all have these signs.
  using QuietRows = std::array<SignRow, 4>;
  QuietRows FindQuiet() const
  {
    const SignRowsAround& rows = this->Around;
    SignRow any = rows.Y | rows.YY | rows.Z | rows.ZM | rows.ZP | rows.ZMM | rows.ZPP | rows.ZZ;
    SignRow all = rows.Y & rows.YY & rows.Z & rows.ZM & rows.ZP & rows.ZMM & rows.ZPP & rows.ZZ;
    if (any.IsZero() || (~all).IsZero())
    {
      return { ~any, {}, {}, all };
    }
    const auto beside = [](const SignRow& row, auto join)
    { return join(row.ShiftUp(), row.ShiftDown()); };
    const auto either = [](const SignRow& a, const SignRow& b) { return a | b; };
    const auto both = [](const SignRow& a, const SignRow& b) { return a & b; };
    const SignRow anyNear = beside(rows.Y | rows.Z, either) | rows.ZM | rows.ZP;
    const SignRow allNear = beside(rows.Y & rows.Z, both) & rows.ZM & rows.ZP;
    any = any | anyNear | beside(anyNear, either);
    all = all & allNear & beside(allNear, both);
    return { ~any, {}, {}, all };
  }

  void CodeRow(SignRow& row)
  {
    const QuietRows quiet = this->FindQuiet();
    // Vertices left of the row have the sign of the first vertex of Z.
    const bool left = this->Around.Z.Get(0);
    const std::uint64_t margin = (std::uint64_t(1) << SignRow::Margin) - 1;
    Coder coder = this->Output;
    SignRow coded;
    coded.Words[0] = left ? margin : 0;
    std::uint32_t before = left ? 3 : 0; // the bits of x - 2 and x - 1, lowest first
    for (int x = 0; x < this->SizeX;)
    {
      if (quiet[before].Get(x))
      {
        x = this->CodeRun(coder, row, coded, quiet[before], x, before != 0);
        before = coded.GetWindow(x) & 3;
      }
      else
      {
        const bool bit = this->Vertices.CodeVertex(coder, row.Get(x), before, this->Around, x);
        coded.Words[static_cast<unsigned>(x + SignRow::Margin) / 64] |= std::uint64_t{ bit }
          << (static_cast<unsigned>(x + SignRow::Margin) % 64);
        before = before >> 1 | (bit ? 2U : 0U);
        ++x;
      }
    }
    row = coded;
    this->Output = coder;
  }

  // Codes a run of quiet vertices from x on; returns the next vertex.
  int CodeRun(
    Coder& coder, const SignRow& row, SignRow& coded, const SignRow& quiet, int x, bool sign)
  {
    const int end = std::min(this->SizeX, FindFirst(~quiet, x));
    const int length = end - x;
    int position = length;
    if constexpr (Coder::Encodes)
    {
      position = std::min(end, FindFirst(sign ? ~row : row, x)) - x;
    }
    const std::size_t context = (sign ? 4 : 0) + (length > 32 ? 3 : length > 8 ? 2 : length > 2);
    const bool whole = CodeAdaptive(coder, this->Quiet[context], position == length, 1023);
    if (!whole)
    {
      const int bits = length == 1 ? 0 : 32 - __builtin_clz(static_cast<unsigned>(length - 1));
      position = static_cast<int>(coder.CodeUniform(static_cast<std::uint32_t>(position), bits));
      position = std::min(position, length - 1); // only for bytes that no encoder wrote
    }
    else
    {
      position = length;
    }
    if (sign)
    {
      coded.SetRange(x, x + position);
    }
    else if (!whole)
    {
      coded.Set(x + position);
    }
    return x + position + (whole ? 0 : 1);
  }

  static int FindFirst(const SignRow& row, int x)
  {
    const auto bit = static_cast<unsigned>(x + SignRow::Margin);
    for (unsigned word = bit / 64; word < 2; ++word)
    {
      const std::uint64_t bits =
        row.Words[word] & (word == bit / 64 ? ~std::uint64_t(0) << (bit % 64) : ~std::uint64_t(0));
      if (bits != 0)
      {
        return static_cast<int>(64 * word) + __builtin_ctzll(bits) - SignRow::Margin;
      }
    }
    return 128;
  }

  ContextSigns<Coder, Mixed> Vertices;
  QuietSigns& Quiet;
  Coder& Output;
  int SizeX;
  int SizeY;
  SignRowsAround Around;
};

} // namespace isosurface

#endif
