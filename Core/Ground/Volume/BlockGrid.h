// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockGrid_h
#define isosurface_BlockGrid_h

#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/VertexBox.h"

#include <cstdint>

namespace isosurface
{

/**
 * Cuts a grid into cubic blocks of `BlockSize` cells a side: 16, 32 or 64, but the last block on an
 * axis may have fewer. Block (I, J, K) begins at the cell (I, J, K) * BlockSize. Its vertices are
 * the corners of its cells, so neighbouring blocks share a face of vertices. An axis with a single
 * vertex has one block without cells.
 *
 * Block index = I + NumberOfBlocks[0] * (J + NumberOfBlocks[1] * K).
 *
 * Level l of the volume holds every vertex whose three coordinates are multiples of 2^l; level 0
 * is the full resolution. Blocks begin at multiples of their size. So up to level log2(BlockSize),
 * neighbouring blocks have the same vertices on their shared face.
 */
class BlockGrid
{
public:
  BlockGrid() = default;
  /// `levels` is the number of levels in a block's record, from the finest on; 0 means the maximum.
  BlockGrid(const Index3& dimensions, int blockSize, int levels = 0);

  const Index3& GetDimensions() const { return this->Dimensions; }
  int GetBlockSize() const { return this->BlockSize; }
  const Index3& GetNumberOfBlocksPerAxis() const { return this->NumberOfBlocks; }
  std::int64_t GetNumberOfBlocks() const
  {
    return this->NumberOfBlocks[0] * this->NumberOfBlocks[1] * this->NumberOfBlocks[2];
  }
  /// The number of levels in a block's record.
  int GetNumberOfLevels() const { return this->Levels; }

  Index3 GetBlockCoordinates(std::int64_t block) const;
  std::int64_t GetBlockIndex(const Index3& coordinates) const;

  /// The vertices of a block's cells at full resolution, those on the high faces included.
  VertexBox GetVertices(std::int64_t block) const;

  /// The vertices at a level, in the coordinates of that level (level-0 coordinates / 2^level).
  VertexBox GetVertices(std::int64_t block, int level) const;

  /// GetVertices() with one more layer of the level's vertices on each side, where the volume has
  /// one. Central differences at the block's vertices need them.
  VertexBox GetGhostedVertices(std::int64_t block, int level) const;

private:
  Index3 Dimensions{ 0, 0, 0 };
  int BlockSize = 0;
  int Levels = 1;
  Index3 NumberOfBlocks{ 0, 0, 0 };
};

/// Whether the format has blocks of this size: 16, 32 or 64.
bool IsBlockSize(int blockSize);

/// log2(blockSize) + 1: at the coarsest level a full block is one cell.
int GetMaximumNumberOfLevels(int blockSize);

} // namespace isosurface

#endif
