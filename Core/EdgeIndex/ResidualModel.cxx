// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/ResidualCoder.h"

namespace isosurface
{

ResidualModel::ResidualModel(bool mixed)
{
  constexpr std::size_t nodes = NumberOfSymbols;
  if (!mixed)
  {
    this->Symbols.resize(std::size_t(NumberOfLevels) * 8);
    return;
  }
  this->ByLevel.resize(NumberOfLevels * nodes);
  for (std::vector<AdaptiveBit>& table : this->BySide)
  {
    table.resize(std::size_t(NumberOfLevels / 2) * NumberOfSides * nodes);
  }
  this->Mixers.resize(NumberOfLevels * nodes);
  for (LogisticMixer& mixer : this->Mixers)
  {
    mixer.Weights = { 6000, 3000, 3000, 3000, 3000, 3000, 0, 0 };
  }
}

} // namespace isosurface
