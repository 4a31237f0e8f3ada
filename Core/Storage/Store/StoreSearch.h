// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreSearch_h
#define isosurface_StoreSearch_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSelection.h"
#include "Storage/Store/QueryStatistics.h"
#include "Storage/Store/VolumeLayout.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

class BlockStore;
class VolumeLayout;

/// The blocks that isosurfaces of a time step and a variable need.
struct BlockQuery
{
  std::size_t TimeStep = 0;
  std::size_t Variable = 0;
  std::vector<double> Isovalues;
  BlockSelection Selection = {}; ///< of the grid of the level that is searched; it needs no lines
};

/// A store, or number Index of Count equal spans of the blocks in it.
struct StoreSpan
{
  std::uint32_t Store = 0;
  std::uint32_t Replica = 0; ///< which is read first
  std::uint64_t Index = 0;
  std::uint64_t Count = 1;

  std::uint64_t FindBegin(std::uint64_t size) const { return size * this->Index / this->Count; }
  std::uint64_t FindEnd(std::uint64_t size) const { return size * (this->Index + 1) / this->Count; }
};

/// What isosurfaces take of the stores that have a level.
struct StoreWork
{
  std::vector<std::uint64_t> Triangles; ///< per store
  std::uint64_t ActiveBlocks = 0;       ///< of all stores
};

/// Searches a store that is open. See BlockedVolume::FindActiveBlocks.
Result<std::vector<BlockReference>> FindActiveBlocks(BlockStore& store, const VolumeLayout& layout,
  const BlockQuery& query, const StoreSpan& span, int level, QueryStatistics& statistics);

/// All blocks of a store that is open, by ordinal. `number`: of the store. `overview`: see StoredLevel.
Result<std::vector<BlockReference>> ListBlocks(
  BlockStore& store, std::uint32_t number, std::uint32_t overview, QueryStatistics& statistics);

} // namespace isosurface

#endif
