// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/BlockActivity.h"

#include <algorithm>

namespace isosurface
{

BlockActivity::BlockActivity(ValueType type, const SpectrumBins& bins)
  : Blocks(bins.Count + std::size_t{ 1 }, 0)
  , Bytes(bins.Count + std::size_t{ 1 }, 0)
{
  for (std::size_t bin = 0; bin < bins.Count; ++bin)
  {
    this->Thresholds.push_back(bins.GetEdgeKey(type, bin));
  }
}

void BlockActivity::Add(const KeyRange& range, std::uint64_t bytes)
{
  if (range.IsEmpty())
  {
    return;
  }
  const auto findBinAbove = [&](ValueKey key)
  {
    return static_cast<std::size_t>(
      std::upper_bound(this->Thresholds.begin(), this->Thresholds.end(), key) -
      this->Thresholds.begin());
  };
  const std::size_t begin = findBinAbove(range.Minimum);
  const std::size_t end = findBinAbove(range.Maximum);
  this->Blocks[begin] += 1;
  this->Blocks[end] -= 1;
  this->Bytes[begin] += bytes;
  this->Bytes[end] -= bytes;
}

void BlockActivity::SetActivity(WorkloadSpectrum& spectrum) const
{
  std::uint64_t blocks = 0;
  std::uint64_t bytes = 0;
  for (std::size_t bin = 0; bin < this->Thresholds.size(); ++bin)
  {
    blocks += this->Blocks[bin];
    bytes += this->Bytes[bin];
    spectrum.ActiveBlocks[bin] = blocks;
    spectrum.Bytes[bin] = bytes;
  }
}

} // namespace isosurface
