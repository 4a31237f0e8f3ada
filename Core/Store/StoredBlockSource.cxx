// SPDX-License-Identifier: BSD-3-Clause
#include "Store/StoredBlockSource.h"

#include <utility>

namespace isosurface
{

StoredBlockSource::StoredBlockSource(BlockedVolume& volume, std::size_t timeStep, std::size_t array,
  int level, std::vector<BlockReference> blocks)
  : Volume(volume)
  , TimeStep(timeStep)
  , Array(array)
  , Level(level)
  , Stored(volume.FindLevel(level))
  , Blocks(std::move(blocks))
{
}

Index3 StoredBlockSource::GetLatticeCoordinates(std::size_t block) const
{
  return this->Stored.Grid->GetBlockCoordinates(this->Blocks[block].Block);
}

VertexBox StoredBlockSource::GetVertices(std::size_t block) const
{
  return this->Stored.Grid->GetVertices(this->Blocks[block].Block, this->Stored.Level);
}

ValueType StoredBlockSource::GetValueType() const
{
  return this->Volume.GetHeader().Arrays[this->Array].Type;
}

void StoredBlockSource::SetAttributes(std::vector<std::size_t> arrays)
{
  this->Attributes = std::move(arrays);
}

Result<BlockSamples> StoredBlockSource::Acquire(std::size_t block)
{
  QueryStatistics statistics;
  std::vector<std::size_t> arrays = this->Attributes;
  arrays.insert(arrays.begin(), this->Array);
  auto blocks =
    this->Volume.ReadArrays(this->Blocks[block], this->TimeStep, arrays, this->Level, statistics);
  {
    const std::lock_guard<std::mutex> lock(this->StatisticsMutex);
    this->Statistics.Add(statistics);
  }
  if (!blocks.IsOk())
  {
    return blocks.GetStatus();
  }
  BlockSamples samples;
  samples.Scalars = blocks->front()->View;
  for (std::size_t n = 1; n < blocks->size(); ++n)
  {
    samples.Attributes.push_back({ { (*blocks)[n]->View } });
  }
  samples.Owner = std::make_shared<DecodedBlocks>(std::move(*blocks));
  return samples;
}

QueryStatistics StoredBlockSource::GetStatistics() const
{
  const std::lock_guard<std::mutex> lock(this->StatisticsMutex);
  return this->Statistics;
}

} // namespace isosurface
