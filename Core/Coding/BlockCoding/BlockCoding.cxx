// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/BlockCoding.h"

#include "Coding/BlockCoding/BlockLayers.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace isosurface
{
namespace
{

// As how many updates a prior counts.
constexpr std::uint32_t SignCount = 10;
constexpr std::uint32_t LevelCount = 8;
constexpr std::uint32_t SideCount = 2;

template <typename Weights>
void SetWeights(const Weights& weights, std::size_t count, LogisticMixer* mixers)
{
  for (std::size_t n = 0; n < count; ++n)
  {
    std::copy_n(weights.begin() + static_cast<std::ptrdiff_t>(n * LogisticMixer::Size),
      LogisticMixer::Size, mixers[n].Weights.begin());
  }
}

} // namespace

SignModel::SignModel(bool mixed)
{
  if (mixed)
  {
    this->Hashed.resize(SignContexts::NumberOfHashed << SignContexts::HashBits);
  }
  std::transform(NearSignPriors.begin(), NearSignPriors.end(), this->Near.begin(),
    [](std::int8_t prior) { return MakeAdaptiveBit(prior, SignCount); });
  std::transform(QuietSignPriors.begin(), QuietSignPriors.end(), this->Quiet.begin(),
    [](std::int8_t prior) { return MakeAdaptiveBit(prior, SignCount); });
  SetWeights(SignMixers, this->Mixers.size(), this->Mixers.data());
}

void SignModel::Reset(const SignModel& fresh)
{
  this->Near = fresh.Near;
  this->Quiet = fresh.Quiet;
  std::fill(this->Hashed.begin(), this->Hashed.end(), AdaptiveBit());
  this->Mixers = fresh.Mixers;
}

ResidualModel::ResidualModel()
  : Symbols(std::size_t(NumberOfLevels) * 8)
{
  for (std::size_t n = 0; n < CrossingSymbols.size(); ++n)
  {
    this->Symbols[n / NumberOfSymbols].Cumulative[n % NumberOfSymbols] =
      static_cast<std::int16_t>(CrossingSymbols[n]);
  }
}

ResidualModel::ResidualModel(
  const std::array<std::int8_t, 512>& levels, const std::array<std::int16_t, 512>& mixers)
{
  const auto makeTree = [&levels](std::size_t level, std::uint32_t count)
  {
    SymbolTree tree;
    for (std::size_t node = 0; node < tree.Nodes.size(); ++node)
    {
      tree.Nodes[node] = MakeAdaptiveBit(levels[level * NumberOfSymbols + node], count);
    }
    return tree;
  };
  for (std::size_t level = 0; level < std::size_t{ NumberOfLevels }; ++level)
  {
    this->ByLevel.push_back(makeTree(level, LevelCount));
  }
  std::vector<SymbolTree> sides;
  for (std::size_t level = 0; level < std::size_t{ NumberOfLevels }; level += 2)
  {
    sides.push_back(makeTree(level, SideCount));
  }
  this->BySide = SideTrees(std::move(sides));
  this->Mixers.resize(NumberOfMixerSets * std::size_t(NumberOfSymbols));
  SetWeights(mixers, this->Mixers.size(), this->Mixers.data());
}

void ResidualModel::Reset(const ResidualModel& fresh)
{
  this->Symbols = fresh.Symbols;
  this->ByLevel = fresh.ByLevel;
  this->BySide.Reset();
  this->Mixers = fresh.Mixers;
  this->Escape = fresh.Escape;
}

ValueModel::ValueModel(bool isUsed)
  : Residuals(isUsed ? ResidualModel(ValueLevels, ValueMixers) : ResidualModel())
{
  for (std::size_t n = 0; n < this->Weights.size(); ++n)
  {
    this->Weights[n] = ValueWeights[InputOrder[n]];
  }
}

void ValueModel::Reset(const ValueModel& fresh)
{
  this->Residuals.Reset(fresh.Residuals);
  this->Weights = fresh.Weights;
  this->MeanHeight = fresh.MeanHeight;
  this->MeanLevel = fresh.MeanLevel;
}

CrossingModel::CrossingModel(bool mixed)
  : Residuals(mixed ? ResidualModel(CrossingLevels, CrossingMixers) : ResidualModel())
{
}

void CrossingModel::Reset(const CrossingModel& fresh)
{
  this->Residuals.Reset(fresh.Residuals);
  this->Missing = fresh.Missing;
  this->MeanLevel = fresh.MeanLevel;
}

void BlockModel::Reset(bool forValues)
{
  const BlockModel& fresh = GetFreshModel(this->Profile);
  this->Signs.Reset(fresh.Signs);
  if (forValues)
  {
    this->Values.Reset(fresh.Values);
  }
  else
  {
    this->Crossings.Reset(fresh.Crossings);
  }
}

const BlockModel& GetFreshModel(EdgeIndexProfile profile)
{
  static const BlockModel small(EdgeIndexProfile::Small);
  static const BlockModel preview(EdgeIndexProfile::Preview);
  static const BlockModel working(EdgeIndexProfile::Working);
  return profile == EdgeIndexProfile::Small ? small
    : profile == EdgeIndexProfile::Preview  ? preview
                                            : working;
}
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
