// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/BlockLayers.h"
#include "Coding/BlockCoding/NewestInstructions.h"

namespace isosurface
{
namespace
{

template <typename Coder, typename VertexSigns>
class SignLayerOf : public SignLayer
{
public:
  SignLayerOf(Coder& coder, typename VertexSigns::Model& model, const BlockContent& content,
    CoderInstructions instructions)
    : Signs(coder, model, content.Size[0], content.Size[1])
    , Instructions(instructions)
  {
  }
  void CodeSlice(SignSlice& slice, const SignSlice* below, const SignSlice* below2) override
  {
    CallWith(this->Instructions, [&] { this->Signs.CodeSlice(slice, below, below2); });
  }

private:
  SignCoder<Coder, VertexSigns> Signs;
  CoderInstructions Instructions;
};

} // namespace

template <typename Coder>
std::unique_ptr<SignLayer> MakeSignLayer(
  Coder& coder, BlockModel& model, const BlockContent& content, CoderInstructions instructions)
{
  switch (model.Profile)
  {
    case EdgeIndexProfile::Compact:
      return std::make_unique<SignLayerOf<Coder, NetworkSigns<Coder>>>(
        coder, model.NetworkSigns, content, instructions);
    case EdgeIndexProfile::Fast:
      return std::make_unique<SignLayerOf<Coder, ContextSigns<Coder, false>>>(
        coder, model.Signs, content, instructions);
    default:
      return std::make_unique<SignLayerOf<Coder, ContextSigns<Coder, true>>>(
        coder, model.Signs, content, instructions);
  }
}

template std::unique_ptr<SignLayer> MakeSignLayer(
  RangeEncoder&, BlockModel&, const BlockContent&, CoderInstructions);
template std::unique_ptr<SignLayer> MakeSignLayer(
  RangeDecoder&, BlockModel&, const BlockContent&, CoderInstructions);

} // namespace isosurface
