// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/BlockCoder.h"
#include "EdgeIndex/EdgeIndexPriors.h"

#include <algorithm>

namespace isosurface
{

SignModel::SignModel(bool mixed)
{
  if (mixed)
  {
    for (std::vector<AdaptiveBit>& table : this->Hashed)
    {
      table.resize(std::size_t(1) << HashBits);
    }
  }
  ApplyPriors(*this);
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
  // At first what the network says counts, and a little of how contexts differ from it.
  WideMixer mixer{};
  const auto contexts = mixer.Weights.begin() + SignNetwork::Depth;
  std::fill_n(contexts, NumberOfContexts, std::int16_t{ 1638 });
  contexts[NumberOfContexts] = 1 << 14;
  for (std::size_t n = 0; n < NumberOfKinds; ++n)
  {
    this->Mixers[n].resize(KindSizes[n], mixer);
  }
  ApplyPriors(*this);
}

void BlockModel::Reset(bool forValues)
{
  const BlockModel& fresh = GetFreshModel(this->Scheme);
  if (this->Scheme == BlockScheme::Compact)
  {
    this->NetSigns = fresh.NetSigns;
  }
  else
  {
    this->Signs = fresh.Signs;
  }
  if (forValues)
  {
    this->Values = fresh.Values;
  }
  else
  {
    this->Crossings = fresh.Crossings;
  }
}

const BlockModel& GetFreshModel(BlockScheme scheme)
{
  static const BlockModel models[] = { BlockModel(BlockScheme::Fast),
    BlockModel(BlockScheme::Mixed), BlockModel(BlockScheme::Fitted),
    BlockModel(BlockScheme::Compact) };
  return models[static_cast<std::size_t>(scheme)];
}

} // namespace isosurface
