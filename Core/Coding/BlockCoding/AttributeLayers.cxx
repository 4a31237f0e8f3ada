// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/BlockLayers.h"
#include "Coding/BlockCoding/NewestInstructions.h"

namespace isosurface
{
namespace
{

template <typename Coder>
class AttributeLayer : public SliceLayer
{
public:
  AttributeLayer(Coder& coder, const BlockContent& content, const CodedAttribute& attribute,
    CoderInstructions instructions)
    : Tuples(coder, attribute, content.Size)
    , Instructions(instructions)
  {
  }
  void CodeSlice(int z, const SignSlice& slice, const SignSlice*, const SignSlice* above) override
  {
    CallWith(this->Instructions, [&] { this->Tuples.CodeSlice(z, slice, above); });
  }

private:
  AttributeCoder<Coder> Tuples;
  CoderInstructions Instructions;
};

} // namespace

template <typename Coder>
std::unique_ptr<SliceLayer> MakeAttributeLayer(Coder& coder, const BlockContent& content,
  const CodedAttribute& attribute, CoderInstructions instructions)
{
  return std::make_unique<AttributeLayer<Coder>>(coder, content, attribute, instructions);
}

template std::unique_ptr<SliceLayer> MakeAttributeLayer(
  RangeEncoder&, const BlockContent&, const CodedAttribute&, CoderInstructions);
template std::unique_ptr<SliceLayer> MakeAttributeLayer(
  RangeDecoder&, const BlockContent&, const CodedAttribute&, CoderInstructions);

} // namespace isosurface
