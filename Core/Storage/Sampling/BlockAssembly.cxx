// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/BlockAssembly.h"

#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/SampleCopy.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

// The vertices that a block contributes: its own without the far faces, which the next block has;
// at the box's border also its ghost layer. So each vertex has one contributor.
VertexBox FindContribution(
  const BlockGrid& grid, const BlockBox& box, std::int64_t block, int level)
{
  const Index3 coordinates = grid.GetBlockCoordinates(block);
  const VertexBox own = grid.GetVertices(block, level);
  VertexBox part = grid.GetGhostedVertices(block, level);
  for (int axis = 0; axis < 3; ++axis)
  {
    if (coordinates[axis] > box.Low[axis])
    {
      part.Low[axis] = own.Low[axis];
    }
    if (coordinates[axis] + 1 < box.High[axis])
    {
      // At a coarse level a block may share its only layer of vertices with the next one.
      const Index3 next{ coordinates[0] + (axis == 0), coordinates[1] + (axis == 1),
        coordinates[2] + (axis == 2) };
      part.High[axis] = grid.GetVertices(grid.GetBlockIndex(next), level).Low[axis];
    }
  }
  return part;
}

} // namespace

bool BlockBox::IsEmpty() const
{
  return this->Low[0] >= this->High[0] || this->Low[1] >= this->High[1] ||
    this->Low[2] >= this->High[2];
}

bool BlockBox::Contains(const Index3& block) const
{
  for (int axis = 0; axis < 3; ++axis)
  {
    if (block[axis] < this->Low[axis] || block[axis] >= this->High[axis])
    {
      return false;
    }
  }
  return true;
}

VertexBox BlockBox::GetVertices(const BlockGrid& grid, int level) const
{
  if (this->IsEmpty())
  {
    return {};
  }
  const Index3 last{ this->High[0] - 1, this->High[1] - 1, this->High[2] - 1 };
  return { grid.GetVertices(grid.GetBlockIndex(this->Low), level).Low,
    grid.GetVertices(grid.GetBlockIndex(last), level).High };
}

VertexBox BlockBox::GetGhostedVertices(const BlockGrid& grid, int level) const
{
  if (this->IsEmpty())
  {
    return {};
  }
  const Index3 last{ this->High[0] - 1, this->High[1] - 1, this->High[2] - 1 };
  return { grid.GetGhostedVertices(grid.GetBlockIndex(this->Low), level).Low,
    grid.GetGhostedVertices(grid.GetBlockIndex(last), level).High };
}

BlockBox PartitionBlocks(const BlockGrid& grid, int piece, int pieces)
{
  BlockBox box;
  box.High = grid.GetNumberOfBlocksPerAxis();
  const auto longest = std::max_element(box.High.begin(), box.High.end());
  const auto axis = static_cast<std::size_t>(longest - box.High.begin());
  const std::int64_t layers = *longest;
  box.Low[axis] = layers * piece / pieces;
  box.High[axis] = layers * (piece + 1) / pieces;
  return box;
}

std::optional<int> FindLevelWithin(const BlockedVolume& volume,
  const std::vector<std::size_t>& arrays, int pieces, std::uint64_t bytes)
{
  for (int level = 0; level < volume.GetNumberOfLevels(); ++level)
  {
    std::uint64_t needed = 0;
    for (const std::size_t array : arrays)
    {
      const auto components =
        static_cast<std::uint64_t>(volume.GetHeader().Arrays[array].Components);
      needed += components * volume.EstimateBytes(volume.GetVariables().GetFirst(array), level);
    }
    const Index3& blocks = volume.FindLevel(level).Grid->GetNumberOfBlocksPerAxis();
    const auto layers =
      static_cast<double>(*std::max_element(blocks.begin(), blocks.end())); // PartitionBlocks
    const double largest = std::ceil(layers / pieces) / layers;
    if (static_cast<double>(needed) * largest <= static_cast<double>(bytes))
    {
      return level;
    }
  }
  return std::nullopt;
}

Status AssembleBlocks(BlockedVolume& volume, std::size_t timeStep, std::size_t variable, int level,
  const BlockBox& box, const std::vector<BlockReference>& blocks, int threads, void* samples,
  std::ptrdiff_t stride, QueryStatistics& statistics, const Progress& progress)
{
  const StoredLevel stored = volume.FindLevel(level);
  const VertexBox whole = box.GetGhostedVertices(*stored.Grid, stored.Level);
  const auto copy = [&](const BlockReference& block, const SampleView& view)
  {
    CopyBox(
      view, FindContribution(*stored.Grid, box, block.Block, stored.Level), whole, samples, stride);
  };
  return VisitBlocks(
    volume, timeStep, variable, level, blocks, threads, copy, statistics, progress);
}

Status VisitBlocks(BlockedVolume& volume, std::size_t timeStep, std::size_t variable, int level,
  const std::vector<BlockReference>& blocks, int threads, const BlockVisitor& visit,
  QueryStatistics& statistics, const Progress& progress)
{
  const auto read = [&](std::size_t block, QueryStatistics& cost) -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto decoded, volume.ReadBlock(blocks[block], timeStep, variable, level, cost));
    visit(blocks[block], decoded->View);
    return Status::Ok();
  };
  return ReadInParallel(
    blocks.size(), volume.ChooseThreads(timeStep, threads), read, statistics, progress);
}

Status ReadInParallel(std::size_t count, int threads, const ReadingStep& step,
  QueryStatistics& statistics, const Progress& progress)
{
  std::vector<QueryStatistics> costs(static_cast<std::size_t>(threads));
  FirstFailure failure;
  const bool finished = ParallelFor(
    count, threads,
    [&](std::size_t index, int thread)
    { failure.Run([&] { return step(index, costs[static_cast<std::size_t>(thread)]); }); },
    progress);
  for (const QueryStatistics& cost : costs)
  {
    statistics.Add(cost);
  }
  ISOSURFACE_RETURN_IF_ERROR(failure.Get());
  return finished ? Status::Ok() : Status(StatusCode::Aborted, "Reading was aborted.");
}

} // namespace isosurface
