// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockCoder_h
#define isosurface_BlockCoder_h

#include "EdgeIndex/AttributeCoder.h"
#include "EdgeIndex/BlockScheme.h"
#include "EdgeIndex/CrossingCoder.h"
#include "EdgeIndex/NetworkSigns.h"
#include "EdgeIndex/SignCoder.h"
#include "EdgeIndex/ValueCoder.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

namespace isosurface
{

/// Where a block's values come from when encoding, and go to when decoding.
class BlockValues
{
public:
  virtual ~BlockValues() = default;

  /// The signs of slice z: given, or to be set. Asked for once a slice, in their order; kept.
  virtual SignSlice& GetSigns(int z) = 0;

  /// Called when the signs of slice z are known.
  virtual void FinishSigns(int z) = 0;

  /// The codes of the values at `vertices` of a row: fills them before they are encoded, or takes
  /// them when they are decoded.
  virtual void ExchangeCodes(int y, int z, const SignRow& vertices, std::int64_t* codes) = 0;

  /// The same for the intervals of the crossed edges along an axis that begin in a row.
  virtual void ExchangeBins(int axis, int y, int z, const SignRow& edges, std::uint32_t* bins) = 0;

  /// Called after every slice: whether to go on.
  virtual bool FinishSlice(int z) = 0;
};

/// What is known about a block.
struct BlockModel
{
  explicit BlockModel(BlockScheme scheme)
    : Scheme(scheme)
    , Signs(scheme != BlockScheme::Compact && IsMixed(scheme))
    , NetSigns(scheme == BlockScheme::Compact)
    , Values(IsMixed(scheme))
    , Crossings(scheme)
  {
  }
  /// Makes it as it is at the begin of each block: what signs need, and values or crossings.
  void Reset(bool forValues);

  BlockScheme Scheme;
  SignModel Signs;           ///< but of the scheme Compact
  NetworkSignModel NetSigns; ///< of the scheme Compact
  ValueModel Values;
  CrossingModel Crossings;
};

/// A model as it is at the begin of each block; made once.
const BlockModel& GetFreshModel(BlockScheme scheme);

/**
 * The code of a block: for each slice first the signs of the next one, since they tell which
 * vertices are relevant and which edges crossed, then the slice's values or crossings.
 */
template <typename Coder, BlockScheme Scheme>
class BlockCoder
{
public:
  BlockCoder(Coder& coder, BlockModel& model, const int size[3])
    : Output(coder)
    , Model(model)
    , Size{ size[0], size[1], size[2] }
    , Signs(coder, GetSigns(model), size[0], size[1])
  {
  }

  /// Codes a point array as well; see AttributeCoder. To be called first. The tuples at `edges` are
  /// given when encoding, and set when decoding; hasExceptions: see AttributeDomain::HasCode.
  void AddAttribute(
    const EdgeIndexAttribute& attribute, const AttributeEdges& edges, bool hasExceptions)
  {
    this->Attributes.push_back(
      std::make_unique<AttributeCoder<Coder>>(this->Output, attribute, edges, this->Size));
    this->Attributes.back()->CodeExceptions(hasExceptions);
  }

  /// With values: see ValueCoder.
  void CodeValues(const ValueDomain& domain, BlockValues& values)
  {
    const auto coder = std::make_unique<ValueCoder<Coder, IsMixed(Scheme), IsFitted(Scheme)>>(
      this->Output, this->Model.Values, domain, this->Size[0], this->Size[1]);
    std::int64_t codes[MaximumCodedVertices];
    this->VisitSlices(values,
      [&](int z, const SignSlice& slice, const SignSlice* below, const SignSlice* above)
      {
        coder->BeginSlice(slice, below, above);
        for (int y = 0; y < this->Size[1] && !coder->GetRelevant().IsEmpty; ++y)
        {
          const SignRow& vertices = coder->GetRelevant().Relevant[static_cast<std::size_t>(y)];
          if constexpr (Coder::Encodes)
          {
            values.ExchangeCodes(y, z, vertices, codes);
          }
          coder->CodeRow(y, codes);
          if constexpr (!Coder::Encodes)
          {
            values.ExchangeCodes(y, z, vertices, codes);
          }
        }
      });
  }

  /// With crossings: see CrossingCoder.
  void CodeCrossings(const CrossingIntervals& intervals, bool missing, BlockValues& values)
  {
    const auto coder = std::make_unique<CrossingCoder<Coder, IsMixed(Scheme), IsCurved(Scheme)>>(
      this->Output, this->Model.Crossings, intervals, missing, this->Size[0], this->Size[1]);
    std::uint32_t row[MaximumCodedVertices];
    this->VisitSlices(values,
      [&](int z, const SignSlice& slice, const SignSlice* below, const SignSlice* above)
      {
        coder->BeginSlice(slice, below, above);
        for (int y = 0; y < this->Size[1]; ++y)
        {
          for (int axis = 0; axis < 3; ++axis)
          {
            const SignRow edges = coder->FindEdges(axis, y);
            if (edges.IsZero())
            {
              continue;
            }
            if constexpr (Coder::Encodes)
            {
              values.ExchangeBins(axis, y, z, edges, row);
            }
            coder->CodeRow(axis, y, edges, row);
            if constexpr (!Coder::Encodes)
            {
              values.ExchangeBins(axis, y, z, edges, row);
            }
          }
        }
      });
  }

private:
  using VertexSigns = std::conditional_t<Scheme == BlockScheme::Compact, NetworkSigns<Coder>,
    ContextSigns<Coder, IsMixed(Scheme)>>;

  static auto& GetSigns(BlockModel& model)
  {
    if constexpr (Scheme == BlockScheme::Compact)
    {
      return model.NetSigns;
    }
    else
    {
      return model.Signs;
    }
  }

  template <typename Functor>
  void VisitSlices(BlockValues& values, const Functor& codeSlice)
  {
    SignSlice* below = nullptr;
    SignSlice* slice = &values.GetSigns(0);
    this->Signs.CodeSlice(*slice, nullptr, nullptr);
    values.FinishSigns(0);
    for (int z = 0; z < this->Size[2]; ++z)
    {
      SignSlice* above = nullptr;
      if (z + 1 < this->Size[2])
      {
        above = &values.GetSigns(z + 1);
        this->Signs.CodeSlice(*above, slice, below);
        values.FinishSigns(z + 1);
      }
      codeSlice(z, *slice, below, above);
      for (const auto& attribute : this->Attributes)
      {
        attribute->CodeSlice(z, *slice, above);
      }
      if (!values.FinishSlice(z))
      {
        return;
      }
      below = slice;
      slice = above;
    }
  }

  Coder& Output;
  BlockModel& Model;
  int Size[3];
  SignCoder<Coder, VertexSigns> Signs;
  std::vector<std::unique_ptr<AttributeCoder<Coder>>> Attributes;
};

} // namespace isosurface

#endif
