// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/BlockCoder.h"
#include "EdgeIndex/EdgeIndexPriors.h"

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

void BlockModel::Reset(bool forValues)
{
  const BlockModel& fresh = GetFreshModel(this->Scheme);
  this->Signs = fresh.Signs;
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
