// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/EdgeIndexPriors.h"
#include "EdgeIndex/SignCoder.h"

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

} // namespace isosurface
