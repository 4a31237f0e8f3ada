// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/BlockLayers.h"
#include "Coding/BlockCoding/NewestInstructions.h"

namespace isosurface
{
namespace
{

template <typename Coder, bool Mixed>
class CrossingLayer : public SliceLayer
{
public:
  CrossingLayer(Coder& coder, BlockModel& model, const BlockContent& content, BlockValues& values,
    CoderInstructions instructions)
    : Edges(coder, model.Crossings, content.Intervals, content.HasMissing, content.Size[0],
        content.Size[1])
    , Values(values)
    , SizeY(content.Size[1])
    , Instructions(instructions)
  {
  }
  void CodeSlice(
    int z, const SignSlice& slice, const SignSlice* below, const SignSlice* above) override
  {
    CallWith(this->Instructions, [&] { this->Code(z, slice, below, above); });
  }

private:
  void Code(int z, const SignSlice& slice, const SignSlice* below, const SignSlice* above)
  {
    std::uint32_t bins[MaximumCodedVertices];
    this->Edges.BeginSlice(slice, below, above);
    for (int line = 0; line < 3 * this->SizeY; ++line)
    {
      const int y = line / 3;
      const int axis = line % 3;
      const SignRow edges = this->Edges.FindEdges(axis, y);
      if (edges.IsZero())
      {
        continue;
      }
      if constexpr (Coder::Encodes)
      {
        this->Values.ExchangeBins(axis, y, z, edges, bins);
      }
      this->Edges.CodeRow(axis, y, edges, bins);
      if constexpr (!Coder::Encodes)
      {
        this->Values.ExchangeBins(axis, y, z, edges, bins);
      }
    }
  }

  CrossingCoder<Coder, Mixed> Edges;
  BlockValues& Values;
  int SizeY;
  CoderInstructions Instructions;
};

} // namespace

template <typename Coder>
std::unique_ptr<SliceLayer> MakeCrossingLayer(Coder& coder, BlockModel& model,
  const BlockContent& content, BlockValues& values, CoderInstructions instructions)
{
  if (model.Profile == EdgeIndexProfile::Small)
  {
    return std::make_unique<CrossingLayer<Coder, true>>(
      coder, model, content, values, instructions);
  }
  return std::make_unique<CrossingLayer<Coder, false>>(coder, model, content, values, instructions);
}

template std::unique_ptr<SliceLayer> MakeCrossingLayer(
  RangeEncoder&, BlockModel&, const BlockContent&, BlockValues&, CoderInstructions);
template std::unique_ptr<SliceLayer> MakeCrossingLayer(
  RangeDecoder&, BlockModel&, const BlockContent&, BlockValues&, CoderInstructions);

} // namespace isosurface
