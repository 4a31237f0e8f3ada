// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockSearch_h
#define isosurface_BlockSearch_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSelection.h"
#include "Storage/Store/BlockReference.h"
#include "Storage/Store/QueryStatistics.h"
#include "Storage/Store/ReplicaBalance.h"
#include "Storage/Store/VolumeStores.h"

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
    , Replicas(stores.GetHeader().NumberOfReplicas)
    , Statistics(statistics)
  {
  }

  /// The blocks that BlockedVolume::FindActiveBlocks finds, sorted by store and ordinal.
  Result<std::vector<BlockReference>> FindActive(
    std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection);

  /// The same of all ranks, each rank's share sorted by store and ordinal. The blocks are dealt,
  /// whatever the number of stores.
  Result<std::vector<std::vector<BlockReference>>> FindActiveShares(
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

  /// Who has a part of a store's blocks: which rank, or which host among those that one rank reads,
  /// with which replica, and how much of the work. The replicas of lost stores have none.
  struct StoreShares
  {
    std::vector<std::vector<ReplicaServer>> Servers; ///< per store
    std::vector<std::vector<std::uint64_t>> Work;    ///< per store and server
  };

  /// Whether each rank reads the stores of its own alone, of which others have replicas.
  bool IsSharedByReplicas() const
  {
    return this->Replicas > 1 && this->Ranks > 1 && !this->DealsBlocks;
  }
  /// The blocks of each store in place of triangles.
  VolumeStores::WorkOfStores CountBlocks() const;
  /// What decides about the shares of ranks, the same on all: the triangles of each store, or, if
  /// the ranks know that one cannot read these, the blocks.
  Result<VolumeStores::WorkOfStores> FindWork(
    std::size_t variable, const std::vector<double>& isovalues);
  /// The replicas of a store that all ranks know to be sound, else the best there are.
  std::vector<std::uint32_t> FindReplicas(std::uint32_t store) const;
  /// The shares of ranks, each with the replicas in the folders of its own stores, or those of
  /// hosts.
  StoreShares ShareAmong(bool ofRanks, const VolumeStores::WorkOfStores& work) const;
  /// This rank's blocks where each reads the stores of its own alone. `list`: the blocks of a
  /// store.
  template <typename List>
  Result<std::vector<BlockReference>> FindByReplicas(
    const VolumeStores::WorkOfStores& work, const List& list);
  /// Spreads the blocks of all stores over the hosts that have replicas.
  void ChooseReplicas(std::size_t variable, const std::vector<double>& isovalues,
    std::vector<BlockReference>& references);

  /// Adds this rank's part of the blocks of a store.
  void TakeShare(const std::vector<BlockReference>& found,
    const std::vector<ReplicaServer>& servers, const std::vector<std::uint64_t>& work,
    std::vector<BlockReference>& references) const;

  std::vector<Share> ListStores() const; ///< whole
  std::vector<Share> ListShares() const; ///< this rank's
  /// Calls `read` with a replica of a store that can be read.
  template <typename Read>
  auto ReadStore(std::uint32_t store, const Read& read)
  {
    const StoreReplica first = { static_cast<std::uint32_t>(this->TimeStep), this->Stored.Part,
      store, this->FindReplicas(store).front() };
    return this->Stores.ReadReplicas(first, StoreFault::Whole, read);
  }
  std::uint32_t GetNumberOfStores() const
  {
    return this->Stores.GetParts()[this->Stored.Part].Header.NumberOfStores;
  }
  /// The active blocks of some stores or parts of them.
  Result<std::vector<BlockReference>> FindActiveIn(const std::vector<Share>& shares,
    std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection);
  /// This rank's blocks among those of all stores.
  std::vector<BlockReference> TakeDealt(const std::vector<BlockReference>& found) const;
  /// The vertices whose blocks go to one rank together: a block's, or, if that leaves each rank
  /// enough to take, those of a chunk of the source, so that no two ranks decode it.
  Index3 FindDealtSize() const;
  /// The rank of each of all blocks that FindActive would find.
  std::vector<std::uint32_t> FindOwners(const std::vector<BlockReference>& found) const;
  Status AddActive(const Share& share, std::size_t variable, const std::vector<double>& isovalues,
    const BlockSelection& selection, std::vector<BlockReference>& references);
  /// The active blocks of a share of a store that the selection has, and those that it adds.
  Result<std::vector<BlockReference>> ListActive(BlockStore& store, const Share& share,
    std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection);
  /// All blocks of a share of a store.
  Result<std::vector<BlockReference>> ListAll(BlockStore& store, const Share& share);
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
  std::uint32_t Replicas;
  QueryStatistics& Statistics;
};

} // namespace isosurface

#endif
