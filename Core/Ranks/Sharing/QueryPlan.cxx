// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Sharing/QueryPlan.h"

#include "Ground/Base/Stopwatch.h"
#include "Ground/Base/WithinMemory.h"
#include "Ranks/Sharing/BlockDealing.h"
#include "Ranks/Sharing/ReplicaBalance.h"

#include <algorithm>
#include <string>
#include <utility>

namespace isosurface
{
namespace
{

using References = std::vector<BlockReference>;

std::vector<std::uint32_t> ListOrdinals(
  References::const_iterator begin, References::const_iterator end)
{
  std::vector<std::uint32_t> ordinals;
  ordinals.reserve(static_cast<std::size_t>(end - begin));
  for (; begin != end; ++begin)
  {
    ordinals.push_back(begin->Ordinal);
  }
  return ordinals;
}

/// The stores, or the span of one, that a rank reads alone.
std::vector<StoreSpan> ListOwnStores(std::uint32_t rank, std::uint32_t ranks, std::uint32_t stores)
{
  if (ranks > stores)
  {
    const std::uint32_t store = rank % stores;
    return { { store, 0, rank / stores, (ranks - store + stores - 1) / stores } };
  }
  std::vector<StoreSpan> spans;
  for (std::uint32_t store = rank; store < stores; store += ranks)
  {
    spans.push_back({ store });
  }
  return spans;
}

/// Makes the plan of one query on one rank.
class Planner
{
public:
  Planner(BlockedVolume& volume, const SurfaceQuery& query, int level, QueryStatistics& statistics)
    : Volume(volume)
    , Query(query)
    , Level(level)
    , Stored(volume.FindLevel(level))
    , Rank(static_cast<std::uint32_t>(query.Rank))
    , Ranks(static_cast<std::uint32_t>(query.Ranks))
    , Stores(volume.GetStoredGrids()[Stored.Overview].Header.NumberOfStores)
    , Replicas(volume.GetHeader().NumberOfReplicas)
    , Statistics(statistics)
  {
  }

  Result<QueryPlan> Plan(PlannedShares shares)
  {
    // Each rank would query the trees of all stores.
    constexpr std::uint32_t maximumStores = 64;
    if (shares == PlannedShares::All ||
      (!this->Volume.HasLocalStores() && this->Ranks > 1 &&
        (this->Stores <= maximumStores || this->Stores < this->Ranks)))
    {
      return this->PlanDealt(shares);
    }
    const bool isSharedByReplicas =
      this->Replicas > 1 && this->Ranks > 1 && this->Volume.HasLocalStores();
    ISOSURFACE_ASSIGN_OR_RETURN(auto blocks,
      isSharedByReplicas ? this->FindByReplicas()
                         : this->FindIn(ListOwnStores(this->Rank, this->Ranks, this->Stores)));
    return this->MakePlan({ std::move(blocks), { 0 }, 0 });
  }

private:
  /// Who has a part of a store's blocks: which rank, or which host among those that one rank reads,
  /// with which replica, and how much of the work. The replicas of lost stores have none.
  struct StoreShares
  {
    std::vector<std::vector<ReplicaServer>> Servers; ///< per store
    std::vector<std::vector<std::uint64_t>> Work;    ///< per store and server
  };

  QueryPlan MakePlan(QueryPlan plan)
  {
    plan.Firsts.push_back(plan.Blocks.size());
    this->Statistics.ActiveBlocks += plan.GetOwnEnd() - plan.GetOwnBegin();
    return plan;
  }

  StoreReplica MakeReplica(std::uint32_t store, std::uint32_t replica) const
  {
    return { static_cast<std::uint32_t>(this->Query.TimeStep), this->Stored.Overview, store,
      replica };
  }
  std::vector<std::uint32_t> FindReplicas(std::uint32_t store) const
  {
    return this->Volume.GetFaults().FindBest(this->MakeReplica(store, 0), this->Replicas);
  }

  /// The active blocks of stores or spans, whose replicas are chosen here.
  Result<References> FindIn(std::vector<StoreSpan> spans)
  {
    References found;
    for (StoreSpan& span : spans)
    {
      span.Replica = this->FindReplicas(span.Store).front();
      ISOSURFACE_ASSIGN_OR_RETURN(const auto active,
        this->Volume.FindActiveBlocks(this->Query, span, this->Level, this->Statistics));
      found.insert(found.end(), active.begin(), active.end());
    }
    if (this->Replicas > 1)
    {
      this->ChooseReplicas(found);
    }
    return found;
  }

  /// The shares of ranks, each with the replicas in the folders of its own stores, or those of
  /// hosts.
  Result<StoreShares> ShareStores(bool isAmongRanks)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto work, this->Volume.FindStoreWork(this->Query, this->Level));
    StoreShares shares;
    for (std::uint32_t store = 0; store < this->Stores; ++store)
    {
      std::vector<ReplicaServer>& servers = shares.Servers.emplace_back();
      for (const std::uint32_t replica : this->FindReplicas(store))
      {
        const std::uint32_t host = FindHost(store, replica, this->Stores);
        const std::uint32_t end = isAmongRanks ? std::max(this->Ranks, this->Stores) : this->Stores;
        for (std::uint32_t rank = host; rank < end; rank += this->Stores)
        {
          const std::uint32_t server = isAmongRanks ? rank % this->Ranks : host;
          if (std::none_of(servers.begin(), servers.end(),
                [&](const ReplicaServer& other) { return other.Server == server; }))
          {
            servers.push_back({ server, replica });
          }
        }
      }
    }
    const std::uint32_t servers = isAmongRanks ? this->Ranks : this->Stores;
    shares.Work = BalanceReplicas(
      work.Triangles, shares.Servers, servers, FindTolerance(work.ActiveBlocks, servers));
    return shares;
  }

  /// This rank's blocks where each reads the stores of its own alone, and others have replicas.
  Result<References> FindByReplicas()
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto shares, this->ShareStores(true));
    References references;
    for (std::uint32_t store = 0; store < this->Stores; ++store)
    {
      const std::vector<ReplicaServer>& servers = shares.Servers[store];
      const auto mine = std::find_if(servers.begin(), servers.end(),
        [&](const ReplicaServer& server) { return server.Server == this->Rank; });
      if (mine == servers.end())
      {
        continue;
      }
      ISOSURFACE_ASSIGN_OR_RETURN(const auto found,
        this->Volume.FindActiveBlocks(
          this->Query, { store, mine->Replica }, this->Level, this->Statistics));
      this->TakeShare(found, servers, shares.Work[store], references);
    }
    return references;
  }

  /// Adds this rank's part of the blocks of a store.
  void TakeShare(const References& found, const std::vector<ReplicaServer>& servers,
    const std::vector<std::uint64_t>& work, References& references) const
  {
    const StoreFaults& faults = this->Volume.GetFaults();
    const std::vector<std::uint32_t> owners =
      ShareBlocks(ListOrdinals(found.begin(), found.end()), work);
    const bool isSound = faults.IsEmpty();
    for (std::size_t block = 0; block < found.size(); ++block)
    {
      // A server whose replica has lost the block leaves it to the next one.
      std::size_t owner = owners[block];
      for (std::size_t tried = 1; !isSound && tried < servers.size(); ++tried)
      {
        const StoreReplica where = this->MakeReplica(found[block].Store, servers[owner].Replica);
        if (faults.GetState(where, true, found[block].Ordinal) != ReplicaState::Lost)
        {
          break;
        }
        owner = (owner + 1) % servers.size();
      }
      if (servers[owner].Server == this->Rank)
      {
        references.push_back(found[block]);
        references.back().Replica = servers[owner].Replica;
      }
    }
  }

  /// Spreads the blocks of all stores over the hosts that have replicas.
  void ChooseReplicas(References& references)
  {
    const auto shares = this->ShareStores(false);
    if (!shares.IsOk())
    {
      // Blocks are the same wherever they are read.
      return;
    }
    for (auto begin = references.begin(); begin != references.end();)
    {
      const std::uint32_t store = begin->Store;
      const auto end = std::find_if(begin, references.end(),
        [store](const BlockReference& block) { return block.Store != store; });
      const std::vector<std::uint32_t> owners =
        ShareBlocks(ListOrdinals(begin, end), shares->Work[store]);
      for (auto owner = owners.begin(); begin != end; ++begin, ++owner)
      {
        begin->Replica = shares->Servers[store][*owner].Replica;
      }
    }
  }

  /// The blocks of all stores, dealt: this rank's alone, or those of all ranks.
  Result<QueryPlan> PlanDealt(PlannedShares shares)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto found, this->FindIn(ListOwnStores(0, 1, this->Stores)));
    const std::vector<std::uint32_t> owners = this->FindOwners(found);
    std::vector<References> dealt(this->Ranks);
    for (std::size_t n = 0; n < found.size(); ++n)
    {
      if (shares == PlannedShares::All || owners[n] == this->Rank)
      {
        dealt[owners[n]].push_back(found[n]);
      }
    }
    if (shares == PlannedShares::Own)
    {
      return this->MakePlan({ std::move(dealt[this->Rank]), { 0 }, 0 });
    }
    QueryPlan plan;
    plan.Own = this->Rank;
    plan.Blocks.reserve(found.size());
    for (const References& share : dealt)
    {
      plan.Firsts.push_back(plan.Blocks.size());
      plan.Blocks.insert(plan.Blocks.end(), share.begin(), share.end());
    }
    return this->MakePlan(std::move(plan));
  }

  /// The vertices whose blocks go to one rank together: a block's, or, if that leaves each rank
  /// enough to take, those of a chunk of the source, so that no two ranks decode it.
  Index3 FindDealtSize() const
  {
    const BlockGrid& grid = *this->Stored.Grid;
    const std::int64_t side = grid.GetBlockSize();
    const Index3 size = { side, side, side };
    if (!this->Volume.IsInSource(this->Stored))
    {
      return size;
    }
    // With fewer chunks a rank, shares would differ too much.
    constexpr std::int64_t chunksOfRank = 16;
    Index3 chunk =
      this->Volume.GetHeader().TimeSteps[this->Query.TimeStep].Source->Chunk.value_or(size);
    std::int64_t chunks = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      chunk[axis] = std::max(chunk[axis], side);
      chunks *= (grid.GetDimensions()[axis] - 1) / chunk[axis] + 1;
    }
    return chunks / chunksOfRank >= this->Ranks ? chunk : size;
  }

  /// The rank of each of all active blocks.
  std::vector<std::uint32_t> FindOwners(const References& found) const
  {
    const BlockDealing dealing(this->Ranks);
    const BlockGrid& grid = *this->Stored.Grid;
    const Index3 size = this->FindDealtSize();
    const std::int64_t side = grid.GetBlockSize();
    const bool isDealtByChunks = size != Index3{ side, side, side };
    std::vector<std::int64_t> blocks;
    std::vector<std::uint32_t> owners;
    for (const BlockReference& block : found)
    {
      if (isDealtByChunks)
      {
        const Index3 first = grid.GetVertices(block.Block).Low;
        owners.push_back(
          dealing.FindRank({ first[0] / size[0], first[1] / size[1], first[2] / size[2] }));
      }
      else
      {
        blocks.push_back(block.Block);
      }
    }
    return isDealtByChunks ? owners : dealing.Deal(grid, blocks);
  }

  BlockedVolume& Volume;
  const SurfaceQuery& Query;
  int Level;
  StoredLevel Stored;
  std::uint32_t Rank;
  std::uint32_t Ranks;
  std::uint32_t Stores; ///< of the part that has the level
  std::uint32_t Replicas;
  QueryStatistics& Statistics;
};

} // namespace

Result<QueryPlan> PlanQuery(BlockedVolume& volume, const SurfaceQuery& query, int level,
  QueryStatistics& statistics, PlannedShares shares)
{
  const Stopwatch stopwatch(statistics.QuerySeconds);
  ISOSURFACE_RETURN_IF_ERROR(volume.CheckArguments(query.TimeStep, query.Variable, level));
  if (query.Rank < 0 || query.Rank >= query.Ranks)
  {
    return Status(StatusCode::InvalidArgument,
      volume.GetPath() + ": there is no rank " + std::to_string(query.Rank) + " of " +
        std::to_string(query.Ranks));
  }
  return RunWithinMemory(volume.GetPath(), BlockedVolume::NoMemoryReason,
    [&] { return Planner(volume, query, level, statistics).Plan(shares); });
}

std::unique_ptr<SharedCounters> MakeClaimCounters(
  Communicator& ranks, const BlockedVolume& volume, const SurfaceQuery& query)
{
  if (ranks.GetSize() == 1)
  {
    return nullptr;
  }
  return ranks.MakeCounters(
    !volume.HasLocalStores() && query.Rank == ranks.GetRank() && query.Ranks == ranks.GetSize());
}

} // namespace isosurface
