// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/RoundPlan.h"

#include <algorithm>

namespace isosurface
{

RoundPlan::RoundPlan(const BlockGrid& grid, std::size_t ranks, std::int64_t begin)
  : Ranks(ranks)
  , Row(grid.GetNumberOfBlocksPerAxis()[0])
  , Layer(Row * grid.GetNumberOfBlocksPerAxis()[1])
  , Blocks(grid.GetNumberOfBlocks())
  , Next(begin)
{
}

BlockSpan RoundPlan::CutSpan(std::int64_t begin, std::int64_t blocks) const
{
  std::int64_t count = blocks;
  if (begin % this->Layer == 0 && blocks >= this->Layer)
  {
    count = blocks / this->Layer * this->Layer;
  }
  else
  {
    const bool isRows = begin % this->Row == 0 && blocks >= this->Row;
    const std::int64_t unit = isRows ? this->Layer : this->Row;
    count = isRows ? blocks / this->Row * this->Row : blocks;
    count = std::min(count, unit - begin % unit);
  }
  return { begin, std::min(this->Blocks, begin + count) };
}

std::vector<BlockSpan> RoundPlan::Propose(std::int64_t blocks) const
{
  // The remaining blocks are divided evenly.
  const auto ranks = static_cast<std::int64_t>(this->Ranks);
  const std::int64_t remaining = this->Blocks - this->Next;
  const std::int64_t share = std::max<std::int64_t>(1, (remaining + ranks - 1) / ranks);
  std::vector<BlockSpan> spans;
  std::int64_t begin = this->Next;
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    spans.push_back(this->CutSpan(begin, std::min(blocks, share)));
    begin = spans.back().End;
  }
  return spans;
}

void RoundPlan::Take(const std::vector<BlockSpan>& spans)
{
  this->Next = spans.back().End;
}

} // namespace isosurface
