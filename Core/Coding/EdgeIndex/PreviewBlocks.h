// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PreviewBlocks_h
#define isosurface_PreviewBlocks_h

#include "Ground/Volume/BlockSource.h"

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace isosurface
{

/// The vertices of a block that its part of the preview has, numbered in the grid of that level; nothing if the block
/// does not begin at such a vertex, or the part has no cells.
std::optional<VertexBox> FindPreviewVertices(const VertexBox& vertices, int level);

/// The samples there.
SampleView TakePreviewSamples(const SampleView& view, const VertexBox& vertices, int level);

/// The parts of a source's blocks that the preview has, of level 0 the blocks, without attributes. The source must
/// outlive it.
class PreviewBlocks : public BlockSource
{
public:
  PreviewBlocks(BlockSource& inner, int level);

  std::size_t GetNumberOfBlocks() const override { return this->Blocks.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Inner.GetLatticeCoordinates(this->Blocks[block].first);
  }
  VertexBox GetVertices(std::size_t block) const override { return this->Blocks[block].second; }
  ValueType GetValueType() const override { return this->Inner.GetValueType(); }
  Result<BlockSamples> Acquire(std::size_t block) override;

private:
  BlockSource& Inner;
  int Level;
  std::vector<std::pair<std::size_t, VertexBox>> Blocks; ///< of the inner source
};

} // namespace isosurface

#endif
