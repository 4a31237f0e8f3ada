// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/StoredBlockSource.h"

#include <algorithm>
#include <string>
#include <utility>

namespace isosurface
{

BlockSamples MakeBlockSamples(
  DecodedBlocks blocks, const ArrayVariables& variables, const std::vector<std::size_t>& arrays)
{
  BlockSamples samples;
  samples.Scalars = blocks.front()->View;
  std::size_t next = 1;
  for (const std::size_t array : arrays)
  {
    AttributeView& attribute = samples.Attributes.emplace_back();
    for (int component = 0; component < variables.GetComponents(array); ++component, ++next)
    {
      attribute.Components.push_back(blocks[next]->View);
    }
  }
  samples.Owner = std::make_shared<DecodedBlocks>(std::move(blocks));
  return samples;
}

StoredBlockSource::StoredBlockSource(BlockedVolume& volume, std::size_t timeStep,
  std::size_t variable, int level, std::vector<BlockReference> blocks)
  : Volume(volume)
  , TimeStep(timeStep)
  , VariableNumber(variable)
  , Level(level)
  , Stored(volume.FindLevel(level))
  , Blocks(std::move(blocks))
  , OwnEnd(Blocks.size())
{
  this->SetAttributes({});
}

Index3 StoredBlockSource::GetLatticeCoordinates(std::size_t block) const
{
  return this->Stored.Grid->GetBlockCoordinates(this->Blocks[block].Block);
}

VertexBox StoredBlockSource::GetVertices(std::size_t block) const
{
  const VertexBox vertices =
    this->Stored.Grid->GetVertices(this->Blocks[block].Block, this->Stored.Level);
  return this->Part ? vertices.Intersect(*this->Part) : vertices;
}

ValueType StoredBlockSource::GetValueType() const
{
  return this->Volume.GetVariables()[this->VariableNumber].Type;
}

void StoredBlockSource::SetAttributes(std::vector<std::size_t> arrays)
{
  this->Attributes = std::move(arrays);
  this->AttributesStatus = Status::Ok();
  this->Variables = { this->VariableNumber };
  const ArrayVariables& all = this->Volume.GetVariables();
  for (const std::size_t array : this->Attributes)
  {
    if (!all.Find(array, 0))
    {
      this->AttributesStatus = Status(StatusCode::InvalidArgument,
        this->Volume.GetPath() + ": has no array " + std::to_string(array));
      return;
    }
    for (int component = 0; component < all.GetComponents(array); ++component)
    {
      this->Variables.push_back(*all.Find(array, component));
    }
  }
  std::uint64_t bytes = 0;
  for (const std::size_t variable : this->Variables)
  {
    bytes += this->Volume.EstimateBytes(variable, this->Level);
  }
  const auto count = static_cast<std::uint64_t>(this->Stored.Grid->GetNumberOfBlocks());
  this->BlocksAhead =
    static_cast<std::size_t>(ReadAheadBytes / std::max<std::uint64_t>(1, bytes / count));
}

void StoredBlockSource::SetOwnBlocks(std::size_t begin, std::size_t end)
{
  this->OwnBegin = begin;
  this->OwnEnd = end;
}

void StoredBlockSource::ReadOthersAhead(std::size_t begin, std::size_t end)
{
  this->Volume.Prefetch(this->Blocks, begin, end, this->TimeStep, this->Variables, this->Level);
}

void StoredBlockSource::ExpectOwnBlocks()
{
  const auto first = this->Blocks.begin();
  const bool areAll = this->OwnEnd - this->OwnBegin == this->Blocks.size();
  this->Volume.Expect(areAll
      ? this->Blocks
      : std::vector<BlockReference>(first + static_cast<std::ptrdiff_t>(this->OwnBegin),
          first + static_cast<std::ptrdiff_t>(this->OwnEnd)),
    this->TimeStep, this->Variables, this->Level);
}

/// Reads half of the blocks that may be ahead at once, so that neighbours are read together.
void StoredBlockSource::ReadAhead(std::size_t block)
{
  if (block < this->OwnBegin || block >= this->OwnEnd)
  {
    return;
  }
  const std::unique_lock<std::mutex> lock(this->ReadAheadMutex, std::try_to_lock);
  if (!lock.owns_lock() || block + this->BlocksAhead / 2 < this->EndOfReadAhead)
  {
    return;
  }
  const std::size_t begin = std::max(this->EndOfReadAhead, block);
  this->EndOfReadAhead = std::min(this->OwnEnd, block + this->BlocksAhead);
  if (begin < this->EndOfReadAhead)
  {
    this->Volume.Prefetch(
      this->Blocks, begin, this->EndOfReadAhead, this->TimeStep, this->Variables, this->Level);
  }
}

Result<BlockSamples> StoredBlockSource::Acquire(std::size_t block)
{
  ISOSURFACE_RETURN_IF_ERROR(this->AttributesStatus);
  std::call_once(this->Expected, [this] { this->ExpectOwnBlocks(); });
  this->ReadAhead(block);
  QueryStatistics statistics;
  auto blocks = this->Volume.ReadVariables(
    this->Blocks[block], this->TimeStep, this->Variables, this->Level, statistics);
  {
    const std::lock_guard<std::mutex> lock(this->StatisticsMutex);
    this->Statistics.Add(statistics);
  }
  ISOSURFACE_RETURN_IF_ERROR(blocks.GetStatus());
  BlockSamples samples =
    MakeBlockSamples(std::move(*blocks), this->Volume.GetVariables(), this->Attributes);
  samples.Scalars.Box = this->GetVertices(block);
  return samples;
}

QueryStatistics StoredBlockSource::GetStatistics() const
{
  const std::lock_guard<std::mutex> lock(this->StatisticsMutex);
  return this->Statistics;
}

} // namespace isosurface
