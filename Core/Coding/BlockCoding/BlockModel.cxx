// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/BlockModel.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

// As how many updates a prior counts.
constexpr std::uint32_t SignCount = 10;
constexpr std::uint32_t LevelCount = 8;
constexpr std::uint32_t SideCount = 2;

void SetPriors(QuietSigns& quiet)
{
  std::transform(QuietSignPriors.begin(), QuietSignPriors.end(), quiet.begin(),
    [](std::int8_t prior) { return MakeAdaptiveBit(prior, SignCount); });
}

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
  SetPriors(this->Quiet);
  SetWeights(SignMixers, this->Mixers.size(), this->Mixers.data());
}

void SignModel::Reset(const SignModel& fresh)
{
  this->Near = fresh.Near;
  this->Quiet = fresh.Quiet;
  std::fill(this->Hashed.begin(), this->Hashed.end(), AdaptiveBit());
  this->Mixers = fresh.Mixers;
}

NetworkSignModel::NetworkSignModel(bool used)
{
  if (!used)
  {
    return;
  }
  for (std::size_t n = 0; n < NumberOfContexts; ++n)
  {
    this->Contexts[n].resize(std::size_t{ 1 } << ContextBits[n]);
  }
  // At first the network's prediction counts in full, and differences in contexts a little.
  WideMixer mixer{};
  const auto contexts = mixer.Weights.begin() + SignNetwork::Depth;
  std::fill_n(contexts, NumberOfContexts, std::int16_t{ 1638 });
  contexts[NumberOfContexts] = 1 << 14;
  for (std::size_t n = 0; n < NumberOfKinds; ++n)
  {
    this->Mixers[n].resize(KindSizes[n], mixer);
  }
  SetPriors(this->Quiet);
}

ResidualModel::ResidualModel(bool mixed, const MagnitudeTables& tables)
{
  if (!mixed)
  {
    this->Symbols.resize(std::size_t(NumberOfLevels) * 8);
    for (std::size_t n = 0; n < tables.Symbols->size(); ++n)
    {
      this->Symbols[n / NumberOfSymbols].Cumulative[n % NumberOfSymbols] =
        static_cast<std::int16_t>((*tables.Symbols)[n]);
    }
    return;
  }
  const auto makeTree = [&tables](std::size_t level, std::uint32_t count)
  {
    SymbolTree tree;
    for (std::size_t node = 0; node < tree.Nodes.size(); ++node)
    {
      tree.Nodes[node] = MakeAdaptiveBit((*tables.Levels)[level * NumberOfSymbols + node], count);
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
  SetWeights(*tables.Mixers, this->Mixers.size(), this->Mixers.data());
}

void ResidualModel::Reset(const ResidualModel& fresh)
{
  this->Symbols = fresh.Symbols;
  this->ByLevel = fresh.ByLevel;
  this->BySide.Reset();
  this->Mixers = fresh.Mixers;
  this->Escape = fresh.Escape;
}

ValueModel::ValueModel(bool mixed)
  : Residuals(mixed, { &ValueLevels, &ValueSymbols, &ValueMixers })
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

CrossingModel::CrossingModel(EdgeIndexProfile profile)
  : Residuals(profile == EdgeIndexProfile::Compact
        ? ResidualModel(true, { &CurvedCrossingLevels, nullptr, &CurvedCrossingMixers })
        : ResidualModel(IsMixed(profile), { &CrossingLevels, &CrossingSymbols, &CrossingMixers }))
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
  if (this->Profile == EdgeIndexProfile::Compact)
  {
    this->NetworkSigns = fresh.NetworkSigns;
  }
  else
  {
    this->Signs.Reset(fresh.Signs);
  }
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
  static const BlockModel models[] = { BlockModel(EdgeIndexProfile::Default),
    BlockModel(EdgeIndexProfile::Fast), BlockModel(EdgeIndexProfile::Compact),
    BlockModel(EdgeIndexProfile::Working) };
  return models[static_cast<std::size_t>(profile)];
}

} // namespace isosurface
