// SPDX-License-Identifier: BSD-3-Clause
#include "Store/StoredBlockSource.h"

#include <utility>

namespace isosurface
{

StoredBlockSource::StoredBlockSource(BlockedVolume& volume, std::size_t timeStep,
  std::size_t variable, int level, std::vector<BlockReference> blocks)
  : Volume(volume)
  , TimeStep(timeStep)
  , VariableNumber(variable)
  , Level(level)
  , Blocks(std::move(blocks))
{
}

Index3 StoredBlockSource::GetLatticeCoordinates(std::size_t block) const
{
  return this->Volume.GetBlockGrid().GetBlockCoordinates(this->Blocks[block].Block);
}

VertexBox StoredBlockSource::GetVertices(std::size_t block) const
{
  return this->Volume.GetBlockGrid().GetVertices(this->Blocks[block].Block, this->Level);
}

ValueType StoredBlockSource::GetValueType() const
{
  return this->Volume.GetVariables()[this->VariableNumber].Type;
}

Result<BlockSamples> StoredBlockSource::Acquire(std::size_t block)
{
  QueryStatistics statistics;
  Result<std::shared_ptr<const DecodedBlock>> decoded = this->Volume.ReadBlock(
    this->Blocks[block], this->TimeStep, this->VariableNumber, this->Level, statistics);
  {
    const std::lock_guard<std::mutex> lock(this->StatisticsMutex);
    this->Statistics.Add(statistics);
  }
  if (!decoded.IsOk())
  {
    return decoded.GetStatus();
  }
  BlockSamples samples;
  samples.Scalars = (*decoded)->View;
  samples.Owner = std::move(*decoded);
  return samples;
}

QueryStatistics StoredBlockSource::GetStatistics() const
{
  const std::lock_guard<std::mutex> lock(this->StatisticsMutex);
  return this->Statistics;
}

} // namespace isosurface
