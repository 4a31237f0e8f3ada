// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/BlockLayers.h"
#include "Coding/BlockCoding/NewestInstructions.h"

namespace isosurface
{
namespace
{

template <typename Coder, bool Mixed>
class SignLayerOf : public SignLayer
{
public:
  SignLayerOf(
    Coder& coder, SignModel& model, const BlockContent& content, CoderInstructions instructions)
    : Signs(coder, model, content.Size[0], content.Size[1])
    , Instructions(instructions)
  {
  }
  void CodeSlice(SignSlice& slice, const SignSlice* below, const SignSlice* below2) override
  {
    CallWith(this->Instructions, [&] { this->Signs.CodeSlice(slice, below, below2); });
  }

private:
  SignCoder<Coder, Mixed> Signs;
  CoderInstructions Instructions;
};

} // namespace

template <typename Coder>
std::unique_ptr<SignLayer> MakeSignLayer(
  Coder& coder, BlockModel& model, const BlockContent& content, CoderInstructions instructions)
{
  if (model.Profile == EdgeIndexProfile::Small)
  {
    return std::make_unique<SignLayerOf<Coder, true>>(coder, model.Signs, content, instructions);
  }
  return std::make_unique<SignLayerOf<Coder, false>>(coder, model.Signs, content, instructions);
}

template std::unique_ptr<SignLayer> MakeSignLayer(
  RangeEncoder&, BlockModel&, const BlockContent&, CoderInstructions);
template std::unique_ptr<SignLayer> MakeSignLayer(
  RangeDecoder&, BlockModel&, const BlockContent&, CoderInstructions);

} // namespace isosurface
