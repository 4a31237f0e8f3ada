// SPDX-License-Identifier: BSD-3-Clause
#include "Contour/GridBlockSource.h"

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
  VertexBox vertices = this->Grid.GetVertices(this->Active[block]);
  for (int axis = 0; axis < 3; ++axis)
  {
    vertices.Low[axis] += this->Samples.Box.Low[axis];
    vertices.High[axis] += this->Samples.Box.Low[axis];
  }
  return vertices;
}

Result<BlockSamples> GridBlockSource::Acquire(std::size_t block)
{
  BlockSamples samples;
  samples.Scalars = this->Samples;
  samples.Scalars.Box = this->GetVertices(block);
  samples.Attributes = this->Attributes;
  return samples;
}

} // namespace isosurface
