// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/LevelSamples.h"

#include "Ground/Base/Buffer.h"
#include "Ground/Base/ReadingStop.h"
#include "Ground/Volume/SampleCopy.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

// What is read of a source at once.
constexpr std::int64_t SourceSlabVertices = std::int64_t{ 1 } << 24;

// Every step-th vertex of a box, numbered from its low corner on: number n is at Low + n * Step.
struct Lattice
{
  VertexBox Box;
  Index3 Step;

  // The numbers of the lattice's vertices within a box.
  VertexBox FindNumbers(const VertexBox& vertices) const
  {
    const VertexBox inside = vertices.Intersect(this->Box);
    VertexBox numbers;
    for (std::size_t axis = 0; axis < 3 && !inside.IsEmpty(); ++axis)
    {
      const std::int64_t step = this->Step[axis];
      numbers.Low[axis] = (inside.Low[axis] - this->Box.Low[axis] + step - 1) / step;
      numbers.High[axis] = (inside.High[axis] - this->Box.Low[axis] + step - 1) / step;
    }
    return numbers;
  }
};

// The samples of a block at the lattice's vertices among `own`: a view of their numbers.
SampleView ThinOut(const SampleView& view, const VertexBox& own, const Lattice& lattice)
{
  SampleView thin = view;
  thin.Box = lattice.FindNumbers(own);
  thin.Available = thin.Box;
  if (!thin.Box.IsEmpty())
  {
    Index3 first = lattice.Box.Low;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      first[axis] += thin.Box.Low[axis] * lattice.Step[axis];
      thin.Stride[axis] *= static_cast<std::ptrdiff_t>(lattice.Step[axis]);
    }
    thin.First = view.AtBytes(first);
  }
  return thin;
}

// The vertices of a block that no block after it has.
VertexBox FindOwn(const BlockGrid& grid, const Index3& block, int level)
{
  VertexBox own = grid.GetVertices(grid.GetBlockIndex(block), level);
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (block[axis] + 1 < grid.GetNumberOfBlocksPerAxis()[axis])
    {
      Index3 next = block;
      ++next[axis];
      // At a coarse level a block may share its only layer of vertices with the next one.
      own.High[axis] = grid.GetVertices(grid.GetBlockIndex(next), level).Low[axis];
    }
  }
  return own;
}

} // namespace

Result<std::shared_ptr<const LevelSamples>> LevelSamples::Open(
  std::shared_ptr<BlockedVolume> volume, std::size_t timeStep, int level)
{
  QueryStatistics unused;
  ISOSURFACE_ASSIGN_OR_RETURN(auto blocks, volume->ListBlocks(timeStep, unused, level));
  std::sort(blocks.begin(), blocks.end(),
    [](const BlockReference& a, const BlockReference& b) { return a.Block < b.Block; });
  std::shared_ptr<LevelSamples> samples(new LevelSamples);
  samples->Stored = volume->FindLevel(level);
  std::int64_t expected = 0;
  for (const BlockReference& block : blocks)
  {
    expected += block.Block == expected;
  }
  if (expected < samples->Stored.Grid->GetNumberOfBlocks() ||
    blocks.size() != static_cast<std::size_t>(expected))
  {
    return Status(StatusCode::Corrupt, volume->GetPath() + ": its stores have not each block once");
  }
  samples->Volume = std::move(volume);
  samples->TimeStep = timeStep;
  samples->Level = level;
  samples->Blocks = std::move(blocks);
  return std::shared_ptr<const LevelSamples>(std::move(samples));
}

VertexBox LevelSamples::GetBox() const
{
  return { { 0, 0, 0 }, this->Volume->GetHeader().Grid.Coarsen(this->Level).GetDimensions() };
}

Index3 LevelSamples::FindBlock(const Index3& vertex) const
{
  const Index3& blocks = this->Stored.Grid->GetNumberOfBlocksPerAxis();
  const std::int64_t side = this->GetBlockSide();
  return { std::min(blocks[0] - 1, vertex[0] / side), std::min(blocks[1] - 1, vertex[1] / side),
    std::min(blocks[2] - 1, vertex[2] / side) };
}

VertexBox LevelSamples::FindCells(const Index3& block) const
{
  const Index3& blocks = this->Stored.Grid->GetNumberOfBlocksPerAxis();
  const Index3 end = this->GetBox().High;
  const std::int64_t side = this->GetBlockSide();
  VertexBox cells;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    cells.Low[axis] = block[axis] * side;
    cells.High[axis] = block[axis] + 1 < blocks[axis] ? cells.Low[axis] + side : end[axis];
  }
  return cells;
}

BlockBox LevelSamples::FindCover(const VertexBox& vertices) const
{
  BlockBox cover;
  if (!vertices.IsEmpty())
  {
    cover.Low = this->FindBlock(vertices.Low);
    cover.High =
      this->FindBlock({ vertices.High[0] - 1, vertices.High[1] - 1, vertices.High[2] - 1 });
    for (std::int64_t& high : cover.High)
    {
      ++high;
    }
  }
  return cover;
}

const BlockReference& LevelSamples::GetBlock(const Index3& block) const
{
  return this->Blocks[static_cast<std::size_t>(this->Stored.Grid->GetBlockIndex(block))];
}

Status LevelSamples::Read(std::size_t variable, const VertexBox& box, const Index3& step,
  int threads, void* samples, std::ptrdiff_t stride, QueryStatistics& statistics,
  const Progress& progress) const
{
  if (this->Level == 0 && !box.IsEmpty() && this->Volume->IsAtAddress(this->TimeStep, variable))
  {
    return this->ReadSource(variable, box, step, samples, stride, statistics, progress);
  }
  const BlockGrid& grid = *this->Stored.Grid;
  const Lattice lattice{ box, step };
  const VertexBox whole = lattice.FindNumbers(box);
  const BlockBox cover = this->FindCover(box);
  std::vector<BlockReference> blocks;
  VisitVertices({ cover.Low, cover.High },
    [&](const Index3& block)
    {
      if (!lattice.FindNumbers(FindOwn(grid, block, this->Stored.Level)).IsEmpty())
      {
        blocks.push_back(this->GetBlock(block));
      }
    });

  const auto copy = [&](const BlockReference& block, const SampleView& view)
  {
    const VertexBox own = FindOwn(grid, grid.GetBlockCoordinates(block.Block), this->Stored.Level);
    const SampleView part = ThinOut(view, own, lattice);
    CopyBox(part, part.Box, whole, samples, stride);
  };
  return VisitBlocks(*this->Volume, this->TimeStep, variable, this->Level, blocks, threads, copy,
    statistics, progress);
}

Status LevelSamples::ReadSource(std::size_t variable, const VertexBox& box, const Index3& step,
  void* samples, std::ptrdiff_t stride, QueryStatistics& statistics, const Progress& progress) const
{
  const Lattice lattice{ box, step };
  const VertexBox whole = lattice.FindNumbers(box);
  const ValueType type = this->Volume->GetVariables()[variable].Type;
  // Where slices are left out, each is read alone.
  const Index3 size = box.GetSize();
  const std::int64_t slices = step[2] > 1
    ? 1
    : std::max<std::int64_t>(1, SourceSlabVertices / std::max<std::int64_t>(1, size[0] * size[1]));
  Buffer<std::uint8_t> bytes(
    static_cast<std::size_t>(size[0] * size[1] * std::min(slices, size[2])) * GetValueSize(type));
  const ReadingStop stop(progress);
  VertexBox slab = box;
  for (; slab.Low[2] < box.High[2]; slab.Low[2] += std::max(slices, step[2]))
  {
    slab.High[2] = std::min(box.High[2], slab.Low[2] + slices);
    ISOSURFACE_RETURN_IF_ERROR(
      this->Volume->ReadSource(this->TimeStep, variable, slab, bytes.GetData(), statistics));
    const SampleView part = ThinOut(MakeSampleView(type, slab, bytes.GetData()), slab, lattice);
    CopyBox(part, part.Box, whole, samples, stride);
    if (progress &&
      !progress(static_cast<double>(slab.High[2] - box.Low[2]) / static_cast<double>(size[2])))
    {
      return Status(StatusCode::Aborted, this->Volume->GetPath() + ": reading was stopped");
    }
  }
  return Status::Ok();
}

Result<std::shared_ptr<const LevelSamples>> LevelsOfVolume::Find(
  const std::shared_ptr<BlockedVolume>& volume, std::size_t timeStep, int level)
{
  constexpr std::size_t most = 64;
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const bool isOther =
    !this->Levels.empty() && &this->Levels.begin()->second->GetVolume() != volume.get();
  const auto known = this->Levels.find({ timeStep, level });
  if (known != this->Levels.end() && !isOther)
  {
    return known->second;
  }
  if (isOther || this->Levels.size() >= most)
  {
    this->Levels.clear();
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto opened, LevelSamples::Open(volume, timeStep, level));
  this->Levels[{ timeStep, level }] = opened;
  return opened;
}

Status SampleComponents(const ArrayVariables& variables, const std::vector<std::size_t>& arrays,
  const std::vector<void*>& values, const Progress& progress, const ComponentSampler& sample)
{
  int all = 0;
  for (const std::size_t array : arrays)
  {
    all += variables.GetComponents(array);
  }
  int done = 0;
  for (std::size_t number = 0; number < arrays.size(); ++number)
  {
    const std::size_t first = variables.GetFirst(arrays[number]);
    const auto components = static_cast<std::size_t>(variables.GetComponents(arrays[number]));
    const std::size_t bytes = GetValueSize(variables[first].Type);
    for (std::size_t component = 0; component < components; ++component, ++done)
    {
      const Progress part = MakePartOfProgress(
        progress, static_cast<double>(done) / all, static_cast<double>(done + 1) / all);
      ISOSURFACE_RETURN_IF_ERROR(
        sample(first + component, static_cast<char*>(values[number]) + component * bytes,
          static_cast<int>(components), part));
    }
  }
  return Status::Ok();
}

} // namespace isosurface
