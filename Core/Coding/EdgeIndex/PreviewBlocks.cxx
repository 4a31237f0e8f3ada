// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/PreviewBlocks.h"

namespace isosurface
{

std::optional<VertexBox> FindPreviewVertices(const VertexBox& vertices, int level)
{
  VertexBox coarse = vertices;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    coarse.Low[axis] = vertices.Low[axis] >> level;
    coarse.High[axis] = ((vertices.High[axis] - 1) >> level) + 1;
    if ((coarse.Low[axis] << level) != vertices.Low[axis] ||
      coarse.High[axis] - coarse.Low[axis] < 2)
    {
      return std::nullopt;
    }
  }
  return coarse;
}

SampleView TakePreviewSamples(const SampleView& view, const VertexBox& vertices, int level)
{
  SampleView coarse = view;
  for (std::ptrdiff_t& stride : coarse.Stride)
  {
    stride *= std::ptrdiff_t{ 1 } << level;
  }
  coarse.Box = coarse.Available = vertices;
  coarse.First = view.AtBytes(view.Box.Low);
  return coarse;
}

PreviewBlocks::PreviewBlocks(BlockSource& inner, int level)
  : Inner(inner)
  , Level(level)
{
  for (std::size_t block = 0; block < inner.GetNumberOfBlocks(); ++block)
  {
    if (const auto vertices = FindPreviewVertices(inner.GetVertices(block), level))
    {
      this->Blocks.emplace_back(block, *vertices);
    }
  }
}

Result<BlockSamples> PreviewBlocks::Acquire(std::size_t block)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto samples, this->Inner.Acquire(this->Blocks[block].first));
  samples.Attributes.clear();
  samples.Scalars = TakePreviewSamples(samples.Scalars, this->Blocks[block].second, this->Level);
  return samples;
}

} // namespace isosurface
