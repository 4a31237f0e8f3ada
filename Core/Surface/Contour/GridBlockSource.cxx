// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/GridBlockSource.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace isosurface
{

GridBlockSource::GridBlockSource(
  const SampleView& samples, const BlockRanges& ranges, const std::vector<double>& isovalues)
  : Samples(samples)
  , Grid(ranges.GetGrid())
  , Active(ranges.FindActiveBlocks(isovalues))
{
}

GridBlockSource::GridBlockSource(const SampleView& samples, const BlockRanges& ranges,
  const std::vector<double>& isovalues, const BlockSelection& selection, const GridGeometry& grid)
  : GridBlockSource(samples, ranges, isovalues)
{
  if (selection.IsPlain())
  {
    return;
  }
  std::vector<std::int64_t> candidates = std::move(this->Active);
  const std::vector<std::int64_t> crossed = candidates;
  if (selection.ClosedSides.AreBeyondInside)
  {
    candidates.resize(static_cast<std::size_t>(this->Grid.GetNumberOfBlocks()));
    std::iota(candidates.begin(), candidates.end(), std::int64_t{ 0 });
  }
  else if (!selection.ClosedSides.IsEmpty())
  {
    const std::vector<std::int64_t> inside = ranges.FindInsideBlocks(isovalues);
    candidates.clear();
    std::set_union(
      crossed.begin(), crossed.end(), inside.begin(), inside.end(), std::back_inserter(candidates));
  }
  this->Active.clear();
  for (const std::int64_t block : candidates)
  {
    const bool isCrossed = std::binary_search(crossed.begin(), crossed.end(), block);
    if (selection.Selects(grid, this->FindVertices(block), isCrossed))
    {
      this->Active.push_back(block);
    }
  }
}

void GridBlockSource::SetAttributes(std::vector<AttributeView> attributes)
{
  this->Attributes = std::move(attributes);
}

Index3 GridBlockSource::GetLatticeCoordinates(std::size_t block) const
{
  return this->Grid.GetBlockCoordinates(this->Active[block]);
}

VertexBox GridBlockSource::GetVertices(std::size_t block) const
{
  return this->FindVertices(this->Active[block]);
}

VertexBox GridBlockSource::FindVertices(std::int64_t block) const
{
  return this->Grid.GetVertices(block).Translate(this->Samples.Box.Low);
}

Result<BlockSamples> GridBlockSource::Acquire(std::size_t block)
{
  BlockSamples samples;
  samples.Scalars = this->Samples;
  samples.Scalars.Box = this->GetVertices(block);
  samples.Attributes = this->Attributes;
  samples.Hidden = this->Hidden.IsEmpty() ? nullptr : &this->Hidden;
  return samples;
}

} // namespace isosurface
