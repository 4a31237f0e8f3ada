// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/EdgeIndexPriors.h"
#include "EdgeIndex/ResidualCoder.h"

namespace isosurface
{

ResidualModel::ResidualModel(bool mixed, const ResidualPriors& priors)
{
  if (mixed)
  {
    this->MakeMixed();
  }
  else
  {
    this->Symbols.resize(std::size_t(NumberOfLevels) * 8);
  }
  ApplyPriors(*this, priors);
}

ResidualModel::ResidualModel(const MixedResidualPriors& priors)
{
  this->MakeMixed();
  ApplyPriors(*this, priors);
}

void ResidualModel::MakeMixed()
{
  this->ByLevel.resize(NumberOfLevels);
  for (std::vector<SymbolTree>& table : this->BySide)
  {
    table.resize(std::size_t(NumberOfLevels / 2) * NumberOfSides);
  }
  this->Mixers.resize(NumberOfMixerSets * std::size_t(NumberOfSymbols));
}

} // namespace isosurface
