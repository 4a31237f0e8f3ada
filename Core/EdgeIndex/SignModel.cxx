// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/SignCoder.h"

namespace isosurface
{

SignModel::SignModel(bool mixed)
{
  for (LogisticMixer& mixer : this->Mixers)
  {
    mixer.Weights = { 5200, 4000, 3000, 3600, 3000, 3000, 0, 0 };
  }
  if (mixed)
  {
    for (std::vector<AdaptiveBit>& table : this->Hashed)
    {
      table.resize(std::size_t(1) << HashBits);
    }
  }
}

} // namespace isosurface
