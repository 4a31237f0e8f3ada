// SPDX-License-Identifier: BSD-3-Clause
#include "Store/StoredBlockSource.h"

#include <string>
#include <utility>

namespace isosurface
{

StoredBlockSource::StoredBlockSource(BlockedVolume& volume, std::size_t timeStep,
  std::size_t variable, int level, std::vector<BlockReference> blocks)
  : Volume(volume)
  , TimeStep(timeStep)
  , VariableNumber(variable)
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
  return this->Volume.GetVariables()[this->VariableNumber].Type;
}

void StoredBlockSource::SetAttributes(std::vector<std::size_t> arrays)
{
  this->Attributes = std::move(arrays);
}

Result<BlockSamples> StoredBlockSource::Acquire(std::size_t block)
{
  QueryStatistics statistics;
  std::vector<std::size_t> variables = { this->VariableNumber };
  const ArrayVariables& all = this->Volume.GetVariables();
  for (const std::size_t array : this->Attributes)
  {
    if (!all.Find(array, 0))
    {
      return Status(StatusCode::InvalidArgument,
        this->Volume.GetPath() + ": has no array " + std::to_string(array));
    }
    for (int component = 0; component < all.GetComponents(array); ++component)
    {
      variables.push_back(*all.Find(array, component));
    }
  }
  auto blocks = this->Volume.ReadVariables(
    this->Blocks[block], this->TimeStep, variables, this->Level, statistics);
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
  std::size_t next = 1;
  for (const std::size_t array : this->Attributes)
  {
    AttributeView& attribute = samples.Attributes.emplace_back();
    for (int component = 0; component < all.GetComponents(array); ++component, ++next)
    {
      attribute.Components.push_back((*blocks)[next]->View);
    }
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
