// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/BlockLayers.h"
#include "Coding/BlockCoding/NewestInstructions.h"

namespace isosurface
{
namespace
{

template <typename Coder>
class ValueLayer : public SliceLayer
{
public:
  ValueLayer(Coder& coder, BlockModel& model, const BlockContent& content, BlockValues& values,
    CoderInstructions instructions)
    : Vertices(coder, model.Values, *content.Domain, content.Size[0], content.Size[1])
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
    std::int64_t codes[MaximumCodedVertices];
    this->Vertices.BeginSlice(slice, below, above);
    const RelevantSlice& relevant = this->Vertices.GetRelevant();
    for (int y = 0; y < this->SizeY && !relevant.IsEmpty; ++y)
    {
      const SignRow& vertices = relevant.Relevant[static_cast<std::size_t>(y)];
      if constexpr (Coder::Encodes)
      {
        this->Values.ExchangeCodes(y, z, vertices, codes);
      }
      this->Vertices.CodeRow(y, codes);
      if constexpr (!Coder::Encodes)
      {
        this->Values.ExchangeCodes(y, z, vertices, codes);
      }
    }
  }

  ValueCoder<Coder> Vertices;
  BlockValues& Values;
  int SizeY;
  CoderInstructions Instructions;
};

} // namespace

template <typename Coder>
std::unique_ptr<SliceLayer> MakeValueLayer(Coder& coder, BlockModel& model,
  const BlockContent& content, BlockValues& values, CoderInstructions instructions)
{
  return std::make_unique<ValueLayer<Coder>>(coder, model, content, values, instructions);
}

template std::unique_ptr<SliceLayer> MakeValueLayer(
  RangeEncoder&, BlockModel&, const BlockContent&, BlockValues&, CoderInstructions);
template std::unique_ptr<SliceLayer> MakeValueLayer(
  RangeDecoder&, BlockModel&, const BlockContent&, BlockValues&, CoderInstructions);

} // namespace isosurface
