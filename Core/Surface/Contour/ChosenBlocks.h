// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ChosenBlocks_h
#define isosurface_ChosenBlocks_h

#include "Ground/Volume/BlockSource.h"

#include <cstddef>
#include <utility>
#include <vector>

namespace isosurface
{

/// Some blocks of a source, as a source of their own. The source must outlive this object.
class ChosenBlocks : public BlockSource
{
public:
  ChosenBlocks(BlockSource& source, std::vector<std::size_t> blocks)
    : Source(source)
    , Blocks(std::move(blocks))
  {
  }
  std::size_t GetNumberOfBlocks() const override { return this->Blocks.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Source.GetLatticeCoordinates(this->Blocks[block]);
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    return this->Source.GetVertices(this->Blocks[block]);
  }
  ValueType GetValueType() const override { return this->Source.GetValueType(); }
  Result<BlockSamples> Acquire(std::size_t block) override
  {
    return this->Source.Acquire(this->Blocks[block]);
  }

private:
  BlockSource& Source;
  std::vector<std::size_t> Blocks; ///< numbers in the source
};

} // namespace isosurface

#endif
