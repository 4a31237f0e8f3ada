// SPDX-License-Identifier: BSD-3-Clause
#include "Store/RoundPlan.h"

#include <algorithm>

namespace isosurface
{

RoundPlan::RoundPlan(const BlockGrid& grid, std::size_t ranks, bool isShared)
  : Ranks(ranks)
  , Row(grid.GetNumberOfBlocksPerAxis()[0])
  , Layer(Row * grid.GetNumberOfBlocksPerAxis()[1])
{
  const std::int64_t blocks = grid.GetNumberOfBlocks();
  const auto lanes = static_cast<std::int64_t>(isShared ? 1 : ranks);
  for (std::int64_t lane = 0; lane < lanes; ++lane)
  {
    this->Lanes.push_back({ blocks * lane / lanes, blocks * (lane + 1) / lanes });
    this->Next.push_back(this->Lanes.back().Begin);
  }
}

std::size_t RoundPlan::FindLane(std::int64_t block) const
{
  const auto found = std::upper_bound(this->Lanes.begin(), this->Lanes.end(), block,
    [](std::int64_t a, const BlockRun& lane) { return a < lane.End; });
  return static_cast<std::size_t>(found - this->Lanes.begin());
}

bool RoundPlan::IsDone() const
{
  bool isDone = true;
  for (std::size_t lane = 0; lane < this->Lanes.size(); ++lane)
  {
    isDone = isDone && this->Next[lane] >= this->Lanes[lane].End;
  }
  return isDone;
}

BlockRun RoundPlan::CutRun(std::int64_t begin, std::int64_t end, std::int64_t blocks) const
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
  return { begin, std::min(end, begin + count) };
}

std::vector<BlockRun> RoundPlan::Propose(std::int64_t blocks) const
{
  std::vector<BlockRun> runs;
  if (this->Lanes.size() == this->Ranks)
  {
    for (std::size_t lane = 0; lane < this->Lanes.size(); ++lane)
    {
      runs.push_back(this->CutRun(this->Next[lane], this->Lanes[lane].End, blocks));
    }
    return runs;
  }
  // What remains at the end is shared out in equal parts.
  const auto ranks = static_cast<std::int64_t>(this->Ranks);
  const std::int64_t end = this->Lanes[0].End;
  const std::int64_t remaining = end - this->Next[0];
  const std::int64_t share = std::max<std::int64_t>(1, (remaining + ranks - 1) / ranks);
  std::int64_t begin = this->Next[0];
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    runs.push_back(this->CutRun(begin, end, std::min(blocks, share)));
    begin = runs.back().End;
  }
  return runs;
}

void RoundPlan::Take(const std::vector<BlockRun>& runs)
{
  for (std::size_t rank = 0; rank < runs.size(); ++rank)
  {
    this->Next[this->Lanes.size() == 1 ? 0 : rank] = runs[rank].End;
    this->Count += runs[rank].GetCount();
  }
}

} // namespace isosurface
