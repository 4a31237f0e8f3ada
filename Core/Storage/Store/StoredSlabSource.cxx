// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/StoredSlabSource.h"

#include "Ground/Volume/SampleCopy.h"
#include "Storage/Store/BlockAssembly.h"

#include <algorithm>
#include <utility>

namespace isosurface
{

Result<std::unique_ptr<StoredSlabSource>> StoredSlabSource::Make(
  std::shared_ptr<BlockedVolume> volume, std::size_t timeStep,
  const std::vector<std::size_t>& arrays, int threads)
{
  QueryStatistics statistics;
  auto blocks = volume->ListBlocks(timeStep, statistics);
  ISOSURFACE_RETURN_IF_ERROR(blocks.GetStatus());
  std::sort(blocks->begin(), blocks->end(),
    [](const BlockReference& a, const BlockReference& b) { return a.Block < b.Block; });
  std::unique_ptr<StoredSlabSource> source(new StoredSlabSource);
  for (const std::size_t array : arrays)
  {
    for (int component = 0; component < volume->GetVariables().GetComponents(array); ++component)
    {
      source->Variables.push_back(*volume->GetVariables().Find(array, component));
    }
  }
  source->Box = { { 0, 0, 0 }, volume->GetBlockGrid().GetDimensions() };
  source->Volume = std::move(volume);
  source->TimeStep = timeStep;
  source->Blocks = std::move(*blocks);
  source->Threads = threads;
  return source;
}

std::uint64_t StoredSlabSource::GetReadBytes(const VertexBox& box) const
{
  std::uint64_t bytes = 0;
  for (const std::size_t variable : this->Variables)
  {
    bytes += GetValueSize(this->Volume->GetVariables()[variable].Type);
  }
  return bytes * static_cast<std::uint64_t>(box.GetNumberOfVertices());
}

std::uint64_t StoredSlabSource::GetHeldBytes() const
{
  return this->Blocks.capacity() * sizeof(BlockReference);
}

Result<SampleSlab> StoredSlabSource::Read(const VertexBox& box)
{
  const BlockGrid& grid = this->Volume->GetBlockGrid();
  const BlockBox cover = FindCover(grid, box);
  std::vector<BlockReference> blocks;
  for (const BlockReference& block : this->Blocks)
  {
    if (cover.Contains(grid.GetBlockCoordinates(block.Block)))
    {
      blocks.push_back(block);
    }
  }
  // Each array begins where values of any type may.
  constexpr std::size_t alignment = sizeof(double);
  auto samples = std::make_shared<std::vector<std::uint8_t>>(
    this->GetReadBytes(box) + alignment * this->Variables.size());
  SampleSlab slab;
  std::uint8_t* first = samples->data();
  QueryStatistics statistics;
  for (const std::size_t variable : this->Variables)
  {
    const SampleView view = MakeSampleView(this->Volume->GetVariables()[variable].Type, box, first);
    ISOSURFACE_RETURN_IF_ERROR(AssembleVertices(
      *this->Volume, this->TimeStep, variable, box, blocks, this->Threads, first, statistics));
    const std::size_t bytes =
      GetValueSize(view.Type) * static_cast<std::size_t>(box.GetNumberOfVertices());
    first += (bytes + alignment - 1) / alignment * alignment;
    slab.Arrays.push_back(view);
  }
  slab.Owner = std::move(samples);
  return slab;
}

} // namespace isosurface
