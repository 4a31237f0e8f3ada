// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/EdgeIndexPriors.h"
#include "EdgeIndex/ResidualCoder.h"

namespace isosurface
{

ResidualModel::ResidualModel(bool mixed, const ResidualPriors& priors)
{
  constexpr std::size_t nodes = NumberOfSymbols;
  if (mixed)
  {
    this->ByLevel.resize(NumberOfLevels * nodes);
    for (std::vector<AdaptiveBit>& table : this->BySide)
    {
      table.resize(std::size_t(NumberOfLevels / 2) * NumberOfSides * nodes);
    }
    this->Mixers.resize(NumberOfMixerSets * nodes);
  }
  else
  {
    this->Symbols.resize(std::size_t(NumberOfLevels) * 8);
  }
  ApplyPriors(*this, priors);
}

} // namespace isosurface
