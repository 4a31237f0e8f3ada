// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SignCoder_h
#define isosurface_SignCoder_h

#include "Coding/BlockCoding/SignContexts.h"
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
