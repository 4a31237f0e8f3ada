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

const BlockModel& GetFreshModel(bool mixed)
{
  static const BlockModel models[2] = { BlockModel(false), BlockModel(true) };
  return models[mixed ? 1 : 0];
}

} // namespace isosurface
