// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockSearch.h"

#include "Storage/Store/BlockDealing.h"

#include <algorithm>
#include <iterator>

namespace isosurface
{
namespace
{

std::vector<std::uint32_t> ListOrdinals(const std::vector<BlockReference>& blocks)
{
  std::vector<std::uint32_t> ordinals;
  ordinals.reserve(blocks.size());
  for (const BlockReference& block : blocks)
  {
    ordinals.push_back(block.Ordinal);
  }
  return ordinals;
}

} // namespace

std::vector<BlockSearch::Share> BlockSearch::ListStores() const
{
  std::vector<Share> shares;
  for (std::uint32_t store = 0; store < this->GetNumberOfStores(); ++store)
  {
    shares.push_back({ store, 0, 1 });
  }
  return shares;
}

std::vector<BlockSearch::Share> BlockSearch::ListShares() const
{
  const std::uint32_t stores = this->GetNumberOfStores();
  std::vector<Share> shares;
  if (this->Ranks > stores)
  {
    const std::uint32_t store = this->Rank % stores;
    shares.push_back({ store, this->Rank / stores, (this->Ranks - store + stores - 1) / stores });
    return shares;
  }
  for (std::uint32_t store = this->Rank; store < stores; store += this->Ranks)
  {
    shares.push_back({ store, 0, 1 });
  }
  return shares;
}

Result<BlockReference> BlockSearch::MakeReference(
  const BlockStore& store, std::uint32_t number, std::uint32_t ordinal)
{
  const auto block = store.FindBlock(ordinal, this->Statistics);
  ISOSURFACE_RETURN_IF_ERROR(block.GetStatus());
  return BlockReference{ *block, number, ordinal, this->Stored.Part, 0 };
}

std::vector<std::uint32_t> BlockSearch::FindReplicas(std::uint32_t store) const
{
  std::vector<std::uint32_t> best;
  auto bestState = ReplicaState::Lost;
  for (std::uint32_t replica = 0; replica < this->Replicas; ++replica)
  {
    const StoreReplica where = { static_cast<std::uint32_t>(this->TimeStep), this->Stored.Part,
      store, replica };
    const ReplicaState state = this->Stores.GetFaults().GetState(where, true);
    if (state < bestState)
    {
      best.clear();
      bestState = state;
    }
    if (state == bestState)
    {
      best.push_back(replica);
    }
  }
  return best;
}

BlockSearch::StoreShares BlockSearch::ShareAmong(
  bool ofRanks, const VolumeStores::WorkOfStores& work) const
{
  const std::uint32_t stores = this->GetNumberOfStores();
  StoreShares shares;
  for (std::uint32_t store = 0; store < stores; ++store)
  {
    std::vector<ReplicaServer>& servers = shares.Servers.emplace_back();
    for (const std::uint32_t replica : this->FindReplicas(store))
    {
      const std::uint32_t host = FindHost(store, replica, stores);
      const std::uint32_t end = ofRanks ? std::max(this->Ranks, stores) : stores;
      for (std::uint32_t rank = host; rank < end; rank += stores)
      {
        const std::uint32_t server = ofRanks ? rank % this->Ranks : host;
        if (std::none_of(servers.begin(), servers.end(),
              [&](const ReplicaServer& other) { return other.Server == server; }))
        {
          servers.push_back({ server, replica });
        }
      }
    }
  }
  const std::uint32_t servers = ofRanks ? this->Ranks : stores;
  shares.Work = BalanceReplicas(
    work.Triangles, shares.Servers, servers, FindTolerance(work.ActiveBlocks, servers));
  return shares;
}

VolumeStores::WorkOfStores BlockSearch::CountBlocks() const
{
  const auto& steps = this->Stores.GetParts()[this->Stored.Part].Header.TimeSteps;
  VolumeStores::WorkOfStores work;
  for (const StoreDescription& store : steps[this->TimeStep].Stores)
  {
    work.Triangles.push_back(store.Blocks);
    work.ActiveBlocks += store.Blocks;
  }
  return work;
}

Result<VolumeStores::WorkOfStores> BlockSearch::FindWork(
  std::size_t variable, const std::vector<double>& isovalues)
{
  StoreFaults& faults = this->Stores.GetFaults();
  const StoreReplica spectra = { static_cast<std::uint32_t>(this->TimeStep), this->Stored.Part,
    StoreReplica::Spectra, 0 };
  if (faults.GetState(spectra, true) != ReplicaState::Sound)
  {
    return this->CountBlocks();
  }
  auto work = this->Stores.FindStoreWork(this->TimeStep, this->Stored.Part, variable, isovalues);
  if (!work.IsOk())
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Stores.CheckNotRewritten(this->TimeStep));
    faults.Add({ spectra, StoreFault::Whole, work.GetStatus().GetMessage() });
  }
  return work;
}

template <typename List>
Result<std::vector<BlockReference>> BlockSearch::FindByReplicas(
  const VolumeStores::WorkOfStores& work, const List& list)
{
  const StoreShares shares = this->ShareAmong(true, work);
  std::vector<BlockReference> references;
  for (std::uint32_t store = 0; store < this->GetNumberOfStores(); ++store)
  {
    const std::vector<ReplicaServer>& servers = shares.Servers[store];
    const auto mine = std::find_if(servers.begin(), servers.end(),
      [&](const ReplicaServer& server) { return server.Server == this->Rank; });
    if (mine == servers.end())
    {
      continue;
    }
    const StoreReplica replica = { static_cast<std::uint32_t>(this->TimeStep), this->Stored.Part,
      store, mine->Replica };
    const auto found = this->Stores.ReadReplicas(
      replica, StoreFault::Whole, [&](BlockStore& opened) { return list(opened, store); });
    ISOSURFACE_RETURN_IF_ERROR(found.GetStatus());
    this->TakeShare(*found, servers, shares.Work[store], references);
  }
  return references;
}

void BlockSearch::TakeShare(const std::vector<BlockReference>& found,
  const std::vector<ReplicaServer>& servers, const std::vector<std::uint64_t>& work,
  std::vector<BlockReference>& references) const
{
  const std::vector<std::uint32_t> owners = ShareBlocks(ListOrdinals(found), work);
  const bool isSound = this->Stores.GetFaults().IsEmpty();
  for (std::size_t block = 0; block < found.size(); ++block)
  {
    // A server whose replica has lost the block leaves it to the next one.
    std::size_t owner = owners[block];
    for (std::size_t tried = 1; !isSound && tried < servers.size(); ++tried)
    {
      const StoreReplica where = { static_cast<std::uint32_t>(this->TimeStep), this->Stored.Part,
        found[block].Store, servers[owner].Replica };
      if (this->Stores.GetFaults().GetState(where, true, found[block].Ordinal) !=
        ReplicaState::Lost)
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

void BlockSearch::ChooseReplicas(std::size_t variable, const std::vector<double>& isovalues,
  std::vector<BlockReference>& references)
{
  const auto work =
    this->Stores.FindStoreWork(this->TimeStep, this->Stored.Part, variable, isovalues);
  if (!work.IsOk())
  {
    // Blocks are the same wherever they are read.
    return;
  }
  const StoreShares shares = this->ShareAmong(false, *work);
  for (auto begin = references.begin(); begin != references.end();)
  {
    const std::uint32_t store = begin->Store;
    const auto end = std::find_if(begin, references.end(),
      [store](const BlockReference& block) { return block.Store != store; });
    const std::vector<std::uint32_t> owners =
      ShareBlocks(ListOrdinals({ begin, end }), shares.Work[store]);
    for (auto owner = owners.begin(); begin != end; ++begin, ++owner)
    {
      begin->Replica = shares.Servers[store][*owner].Replica;
    }
  }
}

Result<std::vector<BlockReference>> BlockSearch::FindActive(
  std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection)
{
  if (this->IsSharedByReplicas())
  {
    const auto work = this->FindWork(variable, isovalues);
    ISOSURFACE_RETURN_IF_ERROR(work.GetStatus());
    auto found = this->FindByReplicas(*work,
      [&](BlockStore& store, std::uint32_t number) {
        return this->ListActive(store, { number, 0, 1 }, variable, isovalues, selection);
      });
    this->Statistics.ActiveBlocks += found.IsOk() ? found->size() : 0;
    return found;
  }
  // Each rank would query the trees of all stores.
  constexpr std::uint32_t maximumStores = 64;
  const std::uint32_t stores = this->GetNumberOfStores();
  const bool isDealt =
    this->DealsBlocks && this->Ranks > 1 && (stores <= maximumStores || stores < this->Ranks);
  auto found = this->FindActiveIn(
    isDealt ? this->ListStores() : this->ListShares(), variable, isovalues, selection);
  ISOSURFACE_RETURN_IF_ERROR(found.GetStatus());
  std::vector<BlockReference> references = isDealt ? this->TakeDealt(*found) : std::move(*found);
  this->Statistics.ActiveBlocks += references.size();
  return references;
}

Result<std::vector<BlockReference>> BlockSearch::FindActiveIn(const std::vector<Share>& shares,
  std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection)
{
  std::vector<BlockReference> found;
  for (const Share& share : shares)
  {
    const Status status = this->AddActive(share, variable, isovalues, selection, found);
    if (!status.IsOk())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Stores.CheckNotRewritten(this->TimeStep));
      return status;
    }
  }
  if (this->Replicas > 1)
  {
    this->ChooseReplicas(variable, isovalues, found);
  }
  return found;
}

Result<std::vector<std::vector<BlockReference>>> BlockSearch::FindActiveShares(
  std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection)
{
  const auto found = this->FindActiveIn(this->ListStores(), variable, isovalues, selection);
  ISOSURFACE_RETURN_IF_ERROR(found.GetStatus());
  const std::vector<std::uint32_t> owners = this->FindOwners(*found);
  std::vector<std::vector<BlockReference>> shares(this->Ranks);
  for (std::size_t n = 0; n < found->size(); ++n)
  {
    shares[owners[n]].push_back((*found)[n]);
  }
  this->Statistics.ActiveBlocks += shares[this->Rank].size();
  return shares;
}

Index3 BlockSearch::FindDealtSize() const
{
  const BlockGrid& grid = *this->Stored.Grid;
  const std::int64_t side = grid.GetBlockSize();
  Index3 size = { side, side, side };
  if (!this->Stores.IsInSource(this->Stored))
  {
    return size;
  }
  // With fewer chunks a rank, shares would differ too much.
  constexpr std::int64_t chunksOfRank = 16;
  Index3 chunk = this->Stores.GetHeader().TimeSteps[this->TimeStep].Source->Chunk;
  std::int64_t chunks = 1;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    chunk[axis] = std::max(chunk[axis], side);
    chunks *= (grid.GetDimensions()[axis] - 1) / chunk[axis] + 1;
  }
  return chunks / chunksOfRank >= this->Ranks ? chunk : size;
}

std::vector<std::uint32_t> BlockSearch::FindOwners(const std::vector<BlockReference>& found) const
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

std::vector<BlockReference> BlockSearch::TakeDealt(const std::vector<BlockReference>& found) const
{
  const std::vector<std::uint32_t> owners = this->FindOwners(found);
  std::vector<BlockReference> references;
  for (std::size_t n = 0; n < found.size(); ++n)
  {
    if (owners[n] == this->Rank)
    {
      references.push_back(found[n]);
    }
  }
  return references;
}

Status BlockSearch::AddActive(const Share& share, std::size_t variable,
  const std::vector<double>& isovalues, const BlockSelection& selection,
  std::vector<BlockReference>& references)
{
  const auto active = this->ReadStore(share.Store,
    [&](BlockStore& store)
    { return this->ListActive(store, share, variable, isovalues, selection); });
  ISOSURFACE_RETURN_IF_ERROR(active.GetStatus());
  references.insert(references.end(), active->begin(), active->end());
  return Status::Ok();
}

Result<std::vector<BlockReference>> BlockSearch::ListActive(BlockStore& store, const Share& share,
  std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection)
{
  std::vector<BlockReference> references;
  if (!selection.IsPlain())
  {
    const auto selected = this->Select(store, share.Store, variable, isovalues, selection);
    ISOSURFACE_RETURN_IF_ERROR(selected.GetStatus());
    const auto first = selected->begin();
    references.assign(first + static_cast<std::ptrdiff_t>(share.FindBegin(selected->size())),
      first + static_cast<std::ptrdiff_t>(share.FindEnd(selected->size())));
    return references;
  }
  const auto active = store.FindActive(variable, isovalues, this->Statistics);
  ISOSURFACE_RETURN_IF_ERROR(active.GetStatus());
  const std::uint64_t end = share.FindEnd(active->size());
  for (std::uint64_t index = share.FindBegin(active->size()); index < end; ++index)
  {
    const auto reference = this->MakeReference(store, share.Store, (*active)[index]);
    ISOSURFACE_RETURN_IF_ERROR(reference.GetStatus());
    references.push_back(*reference);
  }
  return references;
}

Result<std::vector<BlockReference>> BlockSearch::Select(BlockStore& store, std::uint32_t number,
  std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection)
{
  const auto active = store.FindActive(variable, isovalues, this->Statistics);
  ISOSURFACE_RETURN_IF_ERROR(active.GetStatus());
  std::vector<std::uint32_t> candidates = *active;
  if (!selection.ClosedSides.IsEmpty())
  {
    const auto inside = store.FindInside(variable, isovalues, this->Statistics);
    ISOSURFACE_RETURN_IF_ERROR(inside.GetStatus());
    candidates.clear();
    std::set_union(active->begin(), active->end(), inside->begin(), inside->end(),
      std::back_inserter(candidates));
  }
  const GridGeometry geometry = this->Stores.GetHeader().Grid.Coarsen(this->Level);
  BlockSelection placed = selection;
  placed.Lines = this->Stores.GetLines(this->Level);
  std::vector<BlockReference> references;
  for (const std::uint32_t ordinal : candidates)
  {
    const auto reference = this->MakeReference(store, number, ordinal);
    ISOSURFACE_RETURN_IF_ERROR(reference.GetStatus());
    const VertexBox vertices = this->Stored.Grid->GetVertices(reference->Block, this->Stored.Level);
    const bool isCrossed = std::binary_search(active->begin(), active->end(), ordinal);
    if (placed.Selects(geometry, vertices, isCrossed))
    {
      references.push_back(*reference);
    }
  }
  return references;
}

Result<std::vector<BlockReference>> BlockSearch::ListAll(BlockStore& store, const Share& share)
{
  std::vector<BlockReference> references;
  const std::uint64_t size = store.GetNumberOfBlocks();
  for (std::uint64_t index = share.FindBegin(size); index < share.FindEnd(size); ++index)
  {
    const auto reference =
      this->MakeReference(store, share.Store, static_cast<std::uint32_t>(index));
    ISOSURFACE_RETURN_IF_ERROR(reference.GetStatus());
    references.push_back(*reference);
  }
  return references;
}

Result<std::vector<BlockReference>> BlockSearch::FindAll()
{
  if (this->IsSharedByReplicas())
  {
    return this->FindByReplicas(this->CountBlocks(),
      [&](BlockStore& store, std::uint32_t number) {
        return this->ListAll(store, { number, 0, 1 });
      });
  }
  std::vector<BlockReference> references;
  for (const Share& share : this->ListShares())
  {
    const auto all =
      this->ReadStore(share.Store, [&](BlockStore& store) { return this->ListAll(store, share); });
    ISOSURFACE_RETURN_IF_ERROR(all.GetStatus());
    references.insert(references.end(), all->begin(), all->end());
  }
  return references;
}

} // namespace isosurface
