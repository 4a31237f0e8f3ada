// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/BlockCoding.h"

#include "Coding/BlockCoding/BlockLayers.h"

#include <memory>

namespace isosurface
{
namespace
{

template <typename Coder>
void CodeLayers(Coder& coder, BlockModel& model, const BlockContent& content, BlockValues& values,
  CoderInstructions instructions)
{
  std::vector<std::unique_ptr<SliceLayer>> layers;
  layers.push_back(content.Planes ? MakePlaneNumbers<Coder::Encodes>(content, values, instructions)
      : content.Domain            ? MakeValueLayer(coder, model, content, values, instructions)
                                  : MakeCrossingLayer(coder, model, content, values, instructions));
  for (const CodedAttribute& attribute : content.Attributes)
  {
    layers.push_back(MakeAttributeLayer(coder, content, attribute, instructions));
  }
  const std::unique_ptr<SignLayer> signs = content.Planes
    ? MakePlaneSigns<Coder::Encodes>(content, instructions)
    : MakeSignLayer(coder, model, content, instructions);

  const SignSlice* below = nullptr;
  SignSlice* slice = &values.GetSigns(0);
  signs->CodeSlice(*slice, nullptr, nullptr);
  values.FinishSigns(0);
  for (int z = 0; z < content.Size[2]; ++z)
  {
    SignSlice* above = nullptr;
    if (z + 1 < content.Size[2])
    {
      above = &values.GetSigns(z + 1);
      signs->CodeSlice(*above, slice, below);
      values.FinishSigns(z + 1);
    }
    for (const std::unique_ptr<SliceLayer>& layer : layers)
    {
      layer->CodeSlice(z, *slice, below, above);
    }
    if (!values.FinishSlice(z))
    {
      return;
    }
    below = slice;
    slice = above;
  }
}

} // namespace

void CodeBlock(RangeEncoder& coder, BlockModel& model, const BlockContent& content,
  BlockValues& values, CoderInstructions instructions)
{
  CodeLayers(coder, model, content, values, instructions);
}

void CodeBlock(RangeDecoder& coder, BlockModel& model, const BlockContent& content,
  BlockValues& values, CoderInstructions instructions)
{
  CodeLayers(coder, model, content, values, instructions);
}

} // namespace isosurface
