// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoredBlockSource_h
#define isosurface_StoredBlockSource_h

#include "Contour/BlockSource.h"
#include "Store/BlockedVolume.h"
#include "Store/QueryStatistics.h"

#include <cstddef>
#include <mutex>
#include <vector>

namespace isosurface
{

/**
 * Blocks of a blocked volume on disk as an extraction visits them: each is read when its turn
 * comes, through the block cache, and let go afterwards. The blocks must have the level
 * (FindLevel); coordinates are those of the level.
 *
 * The volume must outlive the source. Cost of Acquire: BlockedVolume::ReadBlock, for the array and
 * for each one to interpolate.
 */
class StoredBlockSource : public BlockSource
{
public:
  StoredBlockSource(BlockedVolume& volume, std::size_t timeStep, std::size_t array, int level,
    std::vector<BlockReference> blocks);

  /// Further arrays to interpolate, in the order of the attributes. Those of inactive blocks are
  /// not read.
  void SetAttributes(std::vector<std::size_t> arrays);

  std::size_t GetNumberOfBlocks() const override { return this->Blocks.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override;
  VertexBox GetVertices(std::size_t block) const override;
  ValueType GetValueType() const override;
  Result<BlockSamples> Acquire(std::size_t block) override;

  /// What the blocks acquired so far cost, over all threads.
  QueryStatistics GetStatistics() const;

private:
  BlockedVolume& Volume;
  std::size_t TimeStep;
  std::size_t Array;
  std::vector<std::size_t> Attributes;
  int Level;
  StoredLevel Stored;
  std::vector<BlockReference> Blocks;

  mutable std::mutex StatisticsMutex;
  QueryStatistics Statistics;
};

} // namespace isosurface

#endif
