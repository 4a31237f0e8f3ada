// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SignCoder_h
#define isosurface_SignCoder_h

#include "Coding/EntropyCoding/AdaptiveModels.h"
#include "Coding/Prediction/SignRows.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// The probabilities that a run of quiet vertices, whose decoded neighbours all have one sign, has that
/// sign throughout; by the length of the run.
using QuietSigns = std::array<AdaptiveBit, 8>;

/// What is learnt about the signs of a block in the profiles default and fast.
struct SignModel
{
  static constexpr int NumberOfNeighbors = 12;
  static constexpr int HashBits = 14;
  static constexpr int NumberOfHashed = 5;
  static constexpr std::size_t NumberOfMixers = 128;

  explicit SignModel(bool mixed);

  /// Forgets what was learnt since it was like `fresh`.
  void Reset(const SignModel& fresh);

  /// By 12 decoded neighbours, relative to the sign of the left one; a second table for the first
  /// slice.
  std::array<AdaptiveBit, std::size_t(2) << NumberOfNeighbors> Near;
  QuietSigns Quiet;
  /// By further neighbours; only if mixed.
  std::array<std::vector<AdaptiveBit>, NumberOfHashed> Hashed;
  std::array<LogisticMixer, NumberOfMixers> Mixers;
};

/// The decoded rows around the current one: Y is the row before in the slice, Z the same row in the
/// slice before, M and P are one row before and after Z; doubled letters are two rows or slices away.
struct SignRowsAround
{
  SignRow Y, YY, Z, ZM, ZP, ZMM, ZPP, ZZ, ZZM, ZZP;
};

/// The place of a row, and the slices that are decoded.
struct SignRowPlace
{
  const SignSlice& Slice;  ///< decoded up to the row
  const SignSlice* Below;  ///< the slice before, or null
  const SignSlice* Below2; ///< the one before that, or null
  int Y;
  int SizeX;
  int SizeY;
};

/// Codes the sign of a vertex in contexts of decoded signs. After: G. Taubin, "BLIC: bi-level
/// isosurface compression", IEEE Visualization 2002; here with 13 neighbours and, if mixed, five wider
/// contexts.
template <typename Coder, bool Mixed>
class ContextSigns
{
public:
  using Model = SignModel;

  explicit ContextSigns(SignModel& model)
    : Known(model)
  {
  }

  void BeginRow(const SignRowPlace& place) { this->FirstSlice = place.Below ? 0 : 1; }

  /// Codes the sign of vertex x. own: the signs at x - 2 (bit 0) and x - 1.
  bool CodeVertex(
    Coder& coder, bool bit, std::uint32_t own, const SignRow&, const SignRowsAround& rows, int x)
  {
    const bool flipped = own >> 1 != 0;
    const std::uint32_t flip = flipped ? 31 : 0;
    const std::uint32_t near = FindNear(rows, x, flip);
    AdaptiveBit& nearModel =
      this->Known.Near[near | this->FirstSlice << SignModel::NumberOfNeighbors];
    if constexpr (Mixed)
    {
      return this->CodeWithHashed(coder, bit != flipped, nearModel, near, own, flip, rows, x) !=
        flipped;
    }
    else
    {
      return CodeAdaptive(coder, nearModel, bit != flipped, 255) != flipped;
    }
  }

private:
  // The 12 nearest neighbours.
  static std::uint32_t FindNear(const SignRowsAround& rows, int x, std::uint32_t flip)
  {
    const auto three = [x, flip](const SignRow& row) { return (row.GetWindow(x) ^ flip) >> 1 & 7; };
    return three(rows.Y) | three(rows.Z) << 3 | three(rows.ZM) << 6 | three(rows.ZP) << 9;
  }

  // Codes a bit, relative to the left sign, with the nearest context and the five hashed ones.
  bool CodeWithHashed(Coder& coder, bool bit, AdaptiveBit& nearModel, std::uint32_t near,
    std::uint32_t own, std::uint32_t flip, const SignRowsAround& rows, int x)
  {
    const auto five = [x, flip](const SignRow& row) { return row.GetWindow(x) ^ flip; };
    const std::uint32_t y = five(rows.Y);
    const std::uint32_t z = five(rows.Z);
    const std::uint32_t zp = five(rows.ZP);
    const std::uint32_t yy = five(rows.YY);
    const std::uint32_t zz = five(rows.ZZ);
    const std::uint32_t zmm = five(rows.ZMM);
    const std::uint32_t zpp = five(rows.ZPP);
    const std::uint32_t zzm = five(rows.ZZM);
    const std::uint32_t zzp = five(rows.ZZP);
    const std::uint32_t left = own >> 1;
    const std::uint32_t left2 = (own ^ flip) & 1;
    const std::uint32_t out = left2 | (yy >> 2 & 1) << 1 | (zz >> 2 & 1) << 2 | (y & 1) << 3 |
      (y >> 4) << 4 | (z & 1) << 5 | (z >> 4) << 6;
    const std::uint32_t core = (y >> 2 & 3) | (z >> 2 & 3) << 2 | (zp >> 2 & 1) << 4;
    const auto count = [](std::uint32_t bits)
    { return static_cast<std::uint32_t>(__builtin_popcount(bits)); };
    const std::uint32_t nearCount = count(near);
    const std::uint32_t farCount = count(out) + count(yy) + count(zz) + count(zmm) + count(zpp);
    constexpr std::uint32_t mask = (1u << SignModel::HashBits) - 1;
    const std::uint32_t hashes[SignModel::NumberOfHashed] = { Hash(near | out << 12),
      Hash((near | out << 12) ^
        ((zmm >> 2 & 1) << 20 | (zpp >> 2 & 1) << 21 | (yy >> 1 & 1) << 22 | (yy >> 3 & 1) << 23 |
          (zz >> 1 & 1) << 24 | (zz >> 3 & 1) << 25 | 1u << 30)),
      nearCount | farCount << 4 | core << 9,
      Hash(near | (zz >> 1 & 7) << 12 | (zzm >> 2 & 1) << 15 | (zzp >> 2 & 1) << 16 |
        (yy >> 1 & 7) << 17 | left2 << 20 | 1u << 31),
      Hash(core | out << 5 | (zmm >> 1 & 7) << 12 | (zpp >> 1 & 7) << 15 | (yy >> 1 & 7) << 18 |
        left << 21 | 3u << 30) };
    AdaptiveBit* models[SignModel::NumberOfHashed + 1] = { &nearModel };
    for (std::size_t n = 0; n < SignModel::NumberOfHashed; ++n)
    {
      models[n + 1] = &this->Known.Hashed[n][hashes[n] & mask];
    }
    const std::size_t mixer = core | left2 << 5 | this->FirstSlice << 6;
    return CodeMixed(coder, models, std::make_index_sequence<SignModel::NumberOfHashed + 1>(),
      this->Known.Mixers[mixer], bit, 800, 1);
  }

  static std::uint32_t Hash(std::uint32_t key)
  {
    key *= 0x9E3779B1u;
    return (key ^ key >> 15) >> 3;
  }

  SignModel& Known;
  unsigned FirstSlice = 0;
};

/**
 * Codes the signs of the vertices of a block, slice after slice, each in the order of rows. Crossed
 * edges, active cells and connectivity follow from them. Long runs of equal signs are coded as a
 * whole, other vertices by `VertexSigns`: ContextSigns or NetworkSigns.
 */
template <typename Coder, typename VertexSigns>
class SignCoder
{
public:
  SignCoder(Coder& coder, typename VertexSigns::Model& model, int sizeX, int sizeY)
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
      this->Vertices.BeginRow({ slice, below, below2, y, this->SizeX, this->SizeY });
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

  // The vertices whose neighbours are all outside, and those whose neighbours are all inside.
  void FindQuiet(SignRow& outside, SignRow& inside) const
  {
    const SignRowsAround& rows = this->Around;
    SignRow any = rows.Y | rows.YY | rows.Z | rows.ZM | rows.ZP | rows.ZMM | rows.ZPP | rows.ZZ;
    SignRow all = rows.Y & rows.YY & rows.Z & rows.ZM & rows.ZP & rows.ZMM & rows.ZPP & rows.ZZ;
    if (any.IsZero() || (~all).IsZero())
    {
      outside = ~any;
      inside = all;
      return;
    }
    const auto joinThree = [&](const SignRow& row)
    {
      const SignRow up = row.ShiftUp();
      const SignRow down = row.ShiftDown();
      any = any | row | up | down;
      all = all & row & up & down;
    };
    joinThree(this->Around.Y.ShiftUp());
    joinThree(this->Around.Y.ShiftDown());
    joinThree(this->Around.Z.ShiftUp());
    joinThree(this->Around.Z.ShiftDown());
    joinThree(this->Around.ZM);
    joinThree(this->Around.ZP);
    outside = ~any;
    inside = all;
  }

  void CodeRow(SignRow& row)
  {
    SignRow outside;
    SignRow inside;
    this->FindQuiet(outside, inside);
    // Vertices left of the row have the sign of the first vertex of Z.
    const bool left = this->Around.Z.Get(0);
    const std::uint64_t margin = (std::uint64_t(1) << SignRow::Margin) - 1;
    Coder coder = this->Output;
    SignRow coded;
    coded.Words[0] = left ? margin : 0;
    std::uint32_t before = left ? 3 : 0; // the bits of x - 2 and x - 1, lowest first
    for (int x = 0; x < this->SizeX;)
    {
      const bool sign = (before & 2) != 0;
      if ((before == 0 && outside.Get(x)) || (before == 3 && inside.Get(x)))
      {
        x = this->CodeRun(coder, row, coded, sign ? inside : outside, x, sign);
        before = coded.GetWindow(x) & 3;
      }
      else
      {
        const bool bit =
          this->Vertices.CodeVertex(coder, row.Get(x), before, coded, this->Around, x);
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

  VertexSigns Vertices;
  QuietSigns& Quiet;
  Coder& Output;
  int SizeX;
  int SizeY;
  SignRowsAround Around;
};

} // namespace isosurface

#endif
