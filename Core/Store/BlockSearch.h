// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockSearch_h
#define isosurface_BlockSearch_h

#include "Base/Status.h"
#include "Store/BlockReference.h"
#include "Store/QueryStatistics.h"
#include "Store/VolumeStores.h"
#include "Volume/BlockSelection.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Finds the blocks of one rank's share of a volume, at one level of one time step. For the shares
/// and the costs see BlockedVolume. Arguments must be valid: 0 <= rank < ranks.
class BlockSearch
{
public:
  /// `dealsBlocks`: see BlockedVolume::DealBlocks.
  BlockSearch(VolumeStores& stores, std::size_t timeStep, int level, int rank, int ranks,
    bool dealsBlocks, QueryStatistics& statistics)
    : Stores(stores)
    , TimeStep(timeStep)
    , Level(level)
    , Stored(stores.FindLevel(level))
    , Rank(static_cast<std::uint32_t>(rank))
    , Ranks(static_cast<std::uint32_t>(ranks))
    , DealsBlocks(dealsBlocks)
    , Statistics(statistics)
  {
  }

  /// The blocks that BlockedVolume::FindActiveBlocks finds, sorted by store and ordinal.
  Result<std::vector<BlockReference>> FindActive(
    std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection);

  /// All blocks, in the same order.
  Result<std::vector<BlockReference>> FindAll();

private:
  /// A rank's share of a store: number Index of Count equal ones.
  struct Share
  {
    std::uint32_t Store;
    std::uint64_t Index;
    std::uint64_t Count;

    std::uint64_t FindBegin(std::uint64_t size) const { return size * this->Index / this->Count; }
    std::uint64_t FindEnd(std::uint64_t size) const
    {
      return size * (this->Index + 1) / this->Count;
    }
  };

  std::vector<Share> ListShares() const;
  std::uint32_t GetNumberOfStores() const
  {
    return this->Stores.GetParts()[this->Stored.Part].Header.NumberOfStores;
  }
  /// This rank's blocks among those of all stores that FindActive would find.
  Result<std::vector<BlockReference>> FindDealt(
    std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection);
  /// The vertices whose blocks go to one rank together: a block's, or, if that leaves each rank
  /// enough to take, those of a chunk of the source, so that no two ranks decode it.
  Index3 FindDealtSize() const;
  /// The rank of each of all blocks that FindActive would find.
  std::vector<std::uint32_t> FindOwners(const std::vector<BlockReference>& found) const;
  Status AddActive(const Share& share, std::size_t variable, const std::vector<double>& isovalues,
    const BlockSelection& selection, std::vector<BlockReference>& references);
  /// All blocks of a store that are active or inside, as far as the selection has them.
  Result<std::vector<BlockReference>> Select(BlockStore& store, std::uint32_t number,
    std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection);
  Result<BlockReference> MakeReference(
    const BlockStore& store, std::uint32_t number, std::uint32_t ordinal);

  VolumeStores& Stores;
  std::size_t TimeStep;
  int Level;
  StoredLevel Stored;
  std::uint32_t Rank;
  std::uint32_t Ranks;
  bool DealsBlocks;
  QueryStatistics& Statistics;
};

} // namespace isosurface

#endif
