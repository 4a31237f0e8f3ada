// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/BlockLayers.h"
#include "Coding/BlockCoding/BytePlanes.h"
#include "Coding/BlockCoding/NewestInstructions.h"
#include "Coding/BlockCoding/RelevantVertices.h"

namespace isosurface
{
namespace
{

// The signs of a row as the two rows beside it that are decoded suggest, and the one diagonal to it
// (M. J. Weinberger, G. Seroussi and G. Sapiro, LOCO-I, IEEE Trans. Image Processing, 2000): those
// of the row before and of the slice before if they agree, else those that the diagonal has not.
SignRow PredictSigns(const SignSlice& slice, const SignSlice* below, int y)
{
  if (y == 0)
  {
    return below ? below->At(0) : SignRow();
  }
  const SignRow& before = slice.At(y - 1);
  if (!below)
  {
    return before;
  }
  const SignRow& under = below->At(y);
  return (before & under) | ((before ^ under) & ~below->At(y - 1));
}

template <bool Encodes>
class PlaneSigns : public SignLayer
{
public:
  PlaneSigns(const BlockContent& content, CoderInstructions instructions)
    : Planes(*content.Planes)
    , SizeX(content.Size[0])
    , SizeY(content.Size[1])
    , Instructions(instructions)
  {
  }
  void CodeSlice(SignSlice& slice, const SignSlice* below, const SignSlice*) override
  {
    CallWith(this->Instructions, [&] { this->Code(slice, below); });
  }

private:
  void Code(SignSlice& slice, const SignSlice* below)
  {
    const SignRow vertices = SignRow::MakeMask(this->SizeX);
    for (int y = 0; y < this->SizeY; ++y)
    {
      const SignRow predicted = PredictSigns(slice, below, y);
      if constexpr (Encodes)
      {
        this->Planes.AddRow((slice.At(y) ^ predicted) & vertices);
      }
      else
      {
        slice.At(y) = (this->Planes.TakeRow() ^ predicted) & vertices;
      }
    }
  }

  BytePlanes& Planes;
  int SizeX;
  int SizeY;
  CoderInstructions Instructions;
};

// Offsets: the distance of a value from the threshold, on its side. Bits: the difference from those
// of the isovalue, in zigzag order.
template <bool Encodes>
class PlaneValues : public SliceLayer
{
public:
  PlaneValues(const BlockContent& content, BlockValues& values, CoderInstructions instructions)
    : Planes(*content.Planes)
    , Domain(*content.Domain)
    , Values(values)
    , SizeX(content.Size[0])
    , SizeY(content.Size[1])
    , Instructions(instructions)
  {
    int quarter = 0;
    this->Middle = static_cast<std::uint64_t>(this->Domain.FromHeight(0, quarter));
  }
  void CodeSlice(
    int z, const SignSlice& slice, const SignSlice* below, const SignSlice* above) override
  {
    CallWith(this->Instructions,
      [&]
      {
        if (this->Domain.GetKind() == ValueDomain::Kind::Offsets)
        {
          this->Code<true>(z, slice, below, above);
        }
        else
        {
          this->Code<false>(z, slice, below, above);
        }
      });
  }

private:
  template <bool AreOffsets>
  void Code(int z, const SignSlice& slice, const SignSlice* below, const SignSlice* above)
  {
    std::int64_t codes[MaximumCodedVertices];
    FindRelevant(slice, below, above, this->SizeX, this->SizeY, false, this->Vertices);
    for (int y = 0; y < this->SizeY && !this->Vertices.IsEmpty; ++y)
    {
      const SignRow& vertices = this->Vertices.Relevant[static_cast<std::size_t>(y)];
      if (vertices.IsZero())
      {
        continue;
      }
      const SignRow& signs = slice.At(y);
      if constexpr (Encodes)
      {
        this->Values.ExchangeCodes(y, z, vertices, codes);
        VisitBits(vertices,
          [&](int x) { this->Planes.Add(this->ToNumber<AreOffsets>(codes[x], signs.Get(x))); });
      }
      else
      {
        VisitBits(vertices, [&](int x) { codes[x] = this->TakeCode<AreOffsets>(signs.Get(x)); });
        this->Values.ExchangeCodes(y, z, vertices, codes);
      }
    }
  }

  template <bool AreOffsets>
  std::uint64_t ToNumber(std::int64_t code, bool inside) const
  {
    if constexpr (AreOffsets)
    {
      return static_cast<std::uint64_t>(inside ? code : ~code);
    }
    const std::int64_t difference =
      this->Domain.Wrap(static_cast<std::uint64_t>(code) - this->Middle);
    const auto sign = static_cast<std::uint64_t>(difference < 0 ? -1 : 0);
    return (static_cast<std::uint64_t>(difference) << 1) ^ sign;
  }

  template <bool AreOffsets>
  std::int64_t TakeCode(bool inside)
  {
    if constexpr (AreOffsets)
    {
      const std::int64_t maximum =
        inside ? this->Domain.GetMaximum(true) : ~this->Domain.GetMinimum(false);
      const auto distance =
        static_cast<std::int64_t>(this->Planes.Take(static_cast<std::uint64_t>(maximum)));
      return inside ? distance : ~distance;
    }
    const std::uint64_t number = this->Planes.Take(~std::uint64_t{ 0 });
    return this->Domain.Wrap(this->Middle + ((number >> 1) ^ (0 - (number & 1))));
  }

  BytePlanes& Planes;
  const ValueDomain& Domain;
  BlockValues& Values;
  std::uint64_t Middle = 0; ///< the code of the isovalue; of bits only
  int SizeX;
  int SizeY;
  CoderInstructions Instructions;
  RelevantSlice Vertices;
};

// The numbers of the intervals.
template <bool Encodes>
class PlaneCrossings : public SliceLayer
{
public:
  PlaneCrossings(const BlockContent& content, BlockValues& values, CoderInstructions instructions)
    : Planes(*content.Planes)
    , Values(values)
    , LastNumber(content.Intervals.GetCount() - (content.HasMissing ? 0 : 1))
    , SizeX(content.Size[0])
    , SizeY(content.Size[1])
    , Instructions(instructions)
  {
  }
  void CodeSlice(int z, const SignSlice& slice, const SignSlice*, const SignSlice* above) override
  {
    CallWith(this->Instructions, [&] { this->Code(z, slice, above); });
  }

private:
  void Code(int z, const SignSlice& slice, const SignSlice* above)
  {
    std::uint32_t bins[MaximumCodedVertices];
    for (int line = 0; line < 3 * this->SizeY; ++line)
    {
      const int y = line / 3;
      const int axis = line % 3;
      const SignRow edges = FindCrossedEdges(axis, y, slice, above, this->SizeX, this->SizeY);
      if (edges.IsZero())
      {
        continue;
      }
      if constexpr (Encodes)
      {
        this->Values.ExchangeBins(axis, y, z, edges, bins);
        VisitBits(edges, [&](int x) { this->Planes.Add(bins[x]); });
      }
      else
      {
        VisitBits(edges,
          [&](int x)
          { bins[x] = static_cast<std::uint32_t>(this->Planes.Take(this->LastNumber)); });
        this->Values.ExchangeBins(axis, y, z, edges, bins);
      }
    }
  }

  BytePlanes& Planes;
  BlockValues& Values;
  std::uint32_t LastNumber;
  int SizeX;
  int SizeY;
  CoderInstructions Instructions;
};

} // namespace

template <bool Encodes>
std::unique_ptr<SignLayer> MakePlaneSigns(
  const BlockContent& content, CoderInstructions instructions)
{
  return std::make_unique<PlaneSigns<Encodes>>(content, instructions);
}

template <bool Encodes>
std::unique_ptr<SliceLayer> MakePlaneNumbers(
  const BlockContent& content, BlockValues& values, CoderInstructions instructions)
{
  if (content.Domain)
  {
    return std::make_unique<PlaneValues<Encodes>>(content, values, instructions);
  }
  return std::make_unique<PlaneCrossings<Encodes>>(content, values, instructions);
}

template std::unique_ptr<SignLayer> MakePlaneSigns<false>(const BlockContent&, CoderInstructions);
template std::unique_ptr<SignLayer> MakePlaneSigns<true>(const BlockContent&, CoderInstructions);
template std::unique_ptr<SliceLayer> MakePlaneNumbers<false>(
  const BlockContent&, BlockValues&, CoderInstructions);
template std::unique_ptr<SliceLayer> MakePlaneNumbers<true>(
  const BlockContent&, BlockValues&, CoderInstructions);

} // namespace isosurface
