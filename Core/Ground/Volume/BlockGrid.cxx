// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/BlockGrid.h"

#include <algorithm>

namespace isosurface
{

BlockGrid::BlockGrid(const Index3& dimensions, int blockSize, int levels)
  : Dimensions(dimensions)
  , BlockSize(blockSize)
  , Levels(levels > 0 ? levels : GetMaximumNumberOfLevels(blockSize))
{
  for (int axis = 0; axis < 3; ++axis)
  {
    const std::int64_t cells = std::max<std::int64_t>(0, dimensions[axis] - 1);
    const std::int64_t blocks = (cells + blockSize - 1) / blockSize;
    this->NumberOfBlocks[axis] = dimensions[axis] == 0 ? 0 : std::max<std::int64_t>(1, blocks);
  }
}

Index3 BlockGrid::GetBlockCoordinates(std::int64_t block) const
{
  return { block % this->NumberOfBlocks[0],
    (block / this->NumberOfBlocks[0]) % this->NumberOfBlocks[1],
    block / (this->NumberOfBlocks[0] * this->NumberOfBlocks[1]) };
}

std::int64_t BlockGrid::GetBlockIndex(const Index3& coordinates) const
{
  return coordinates[0] +
    this->NumberOfBlocks[0] * (coordinates[1] + this->NumberOfBlocks[1] * coordinates[2]);
}

VertexBox BlockGrid::GetVertices(std::int64_t block) const
{
  return this->GetVertices(block, 0);
}

VertexBox BlockGrid::GetVertices(std::int64_t block, int level) const
{
  const Index3 coordinates = this->GetBlockCoordinates(block);
  VertexBox box;
  for (int axis = 0; axis < 3; ++axis)
  {
    const std::int64_t first = coordinates[axis] * this->BlockSize;
    const std::int64_t last = std::min(first + this->BlockSize, this->Dimensions[axis] - 1);
    box.Low[axis] = first >> level;
    box.High[axis] = (last >> level) + 1;
  }
  return box;
}

VertexBox BlockGrid::GetGhostedVertices(std::int64_t block, int level) const
{
  Index3 dimensions;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    dimensions[axis] = ((this->Dimensions[axis] - 1) >> level) + 1;
  }
  return this->GetVertices(block, level).AddLayer(dimensions);
}

bool IsBlockSize(int blockSize)
{
  return blockSize == 16 || blockSize == 32 || blockSize == 64;
}

int GetMaximumNumberOfLevels(int blockSize)
{
  int levels = 1;
  while ((blockSize >> levels) > 0)
  {
    ++levels;
  }
  return levels;
}

} // namespace isosurface
