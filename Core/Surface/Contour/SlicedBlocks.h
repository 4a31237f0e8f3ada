// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SlicedBlocks_h
#define isosurface_SlicedBlocks_h

#include "Ground/Volume/BlockSource.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// The blocks of a source between two slices of vertices, as a source of its own: blocks that are cut
/// there have fewer cells. Gradients take samples beyond. The source must outlive this object.
class SlicedBlocks : public BlockSource
{
public:
  /// The cells from slice `begin` to slice `end` of vertices.
  SlicedBlocks(BlockSource& source, std::int64_t begin, std::int64_t end)
    : Source(source)
    , Begin(begin)
    , End(end)
  {
    for (std::size_t block = 0; block < source.GetNumberOfBlocks(); ++block)
    {
      const VertexBox vertices = source.GetVertices(block);
      if (vertices.Low[2] < end && vertices.High[2] - 1 > begin)
      {
        this->Blocks.push_back(block);
      }
    }
  }
  std::size_t GetNumberOfBlocks() const override { return this->Blocks.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Source.GetLatticeCoordinates(this->Blocks[block]);
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    VertexBox vertices = this->Source.GetVertices(this->Blocks[block]);
    vertices.Low[2] = std::max(vertices.Low[2], this->Begin);
    vertices.High[2] = std::min(vertices.High[2], this->End + 1);
    return vertices;
  }
  ValueType GetValueType() const override { return this->Source.GetValueType(); }
  Result<BlockSamples> Acquire(std::size_t block) override
  {
    auto samples = this->Source.Acquire(this->Blocks[block]);
    if (samples.IsOk())
    {
      samples->Scalars.Box = this->GetVertices(block);
    }
    return samples;
  }

private:
  BlockSource& Source;
  const std::int64_t Begin;
  const std::int64_t End;
  std::vector<std::size_t> Blocks; ///< numbers in the source
};

} // namespace isosurface

#endif
