// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockSearch.h"

#include "Store/BlockDealing.h"

#include <algorithm>
#include <iterator>

namespace isosurface
{

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
  if (!block.IsOk())
  {
    return block.GetStatus();
  }
  return BlockReference{ *block, number, ordinal, this->Stored.Part };
}

Result<std::vector<BlockReference>> BlockSearch::FindActive(
  std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection)
{
  // Each rank would query the trees of all stores.
  constexpr std::uint32_t maximumStores = 64;
  const std::uint32_t stores = this->GetNumberOfStores();
  if (this->DealsBlocks && this->Ranks > 1 && (stores <= maximumStores || stores < this->Ranks))
  {
    return this->FindDealt(variable, isovalues, selection);
  }
  std::vector<BlockReference> references;
  for (const Share& share : this->ListShares())
  {
    const Status status = this->AddActive(share, variable, isovalues, selection, references);
    if (!status.IsOk())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Stores.CheckNotRewritten(this->TimeStep));
      return status;
    }
  }
  this->Statistics.ActiveBlocks += references.size();
  return references;
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

Result<std::vector<BlockReference>> BlockSearch::FindDealt(
  std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection)
{
  std::vector<BlockReference> found;
  for (std::uint32_t store = 0; store < this->GetNumberOfStores(); ++store)
  {
    const Status status = this->AddActive({ store, 0, 1 }, variable, isovalues, selection, found);
    if (!status.IsOk())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Stores.CheckNotRewritten(this->TimeStep));
      return status;
    }
  }
  const std::vector<std::uint32_t> owners = this->FindOwners(found);
  std::vector<BlockReference> references;
  for (std::size_t n = 0; n < found.size(); ++n)
  {
    if (owners[n] == this->Rank)
    {
      references.push_back(found[n]);
    }
  }
  this->Statistics.ActiveBlocks += references.size();
  return references;
}

Status BlockSearch::AddActive(const Share& share, std::size_t variable,
  const std::vector<double>& isovalues, const BlockSelection& selection,
  std::vector<BlockReference>& references)
{
  const auto store = this->Stores.GetStore(this->TimeStep, this->Stored.Part, share.Store);
  ISOSURFACE_RETURN_IF_ERROR(store.GetStatus());
  if (!selection.IsPlain())
  {
    const auto selected = this->Select(**store, share.Store, variable, isovalues, selection);
    ISOSURFACE_RETURN_IF_ERROR(selected.GetStatus());
    const auto first = selected->begin();
    references.insert(references.end(),
      first + static_cast<std::ptrdiff_t>(share.FindBegin(selected->size())),
      first + static_cast<std::ptrdiff_t>(share.FindEnd(selected->size())));
    return Status::Ok();
  }
  const auto active = (*store)->FindActive(variable, isovalues, this->Statistics);
  ISOSURFACE_RETURN_IF_ERROR(active.GetStatus());
  const std::uint64_t end = share.FindEnd(active->size());
  for (std::uint64_t index = share.FindBegin(active->size()); index < end; ++index)
  {
    const auto reference = this->MakeReference(**store, share.Store, (*active)[index]);
    ISOSURFACE_RETURN_IF_ERROR(reference.GetStatus());
    references.push_back(*reference);
  }
  return Status::Ok();
}

Result<std::vector<BlockReference>> BlockSearch::Select(BlockStore& store, std::uint32_t number,
  std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection)
{
  const auto active = store.FindActive(variable, isovalues, this->Statistics);
  if (!active.IsOk())
  {
    return active.GetStatus();
  }
  std::vector<std::uint32_t> candidates = *active;
  if (!selection.ClosedSides.IsEmpty())
  {
    const auto inside = store.FindInside(variable, isovalues, this->Statistics);
    if (!inside.IsOk())
    {
      return inside.GetStatus();
    }
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
    if (!reference.IsOk())
    {
      return reference.GetStatus();
    }
    const VertexBox vertices = this->Stored.Grid->GetVertices(reference->Block, this->Stored.Level);
    const bool isCrossed = std::binary_search(active->begin(), active->end(), ordinal);
    if (placed.Selects(geometry, vertices, isCrossed))
    {
      references.push_back(*reference);
    }
  }
  return references;
}

Result<std::vector<BlockReference>> BlockSearch::FindAll()
{
  std::vector<BlockReference> references;
  for (const Share& share : this->ListShares())
  {
    const auto store = this->Stores.GetStore(this->TimeStep, this->Stored.Part, share.Store);
    if (!store.IsOk())
    {
      return store.GetStatus();
    }
    const std::uint64_t size = (*store)->GetNumberOfBlocks();
    for (std::uint64_t index = share.FindBegin(size); index < share.FindEnd(size); ++index)
    {
      const auto reference =
        this->MakeReference(**store, share.Store, static_cast<std::uint32_t>(index));
      if (!reference.IsOk())
      {
        return reference.GetStatus();
      }
      references.push_back(*reference);
    }
  }
  return references;
}

} // namespace isosurface
