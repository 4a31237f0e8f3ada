// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockReading.h"

#include "Storage/Record/BlockRecord.h"

namespace isosurface
{

void BlockReading::Announce(const std::vector<std::size_t>& variables)
{
  const ArrayVariables& all = this->Stores.GetLayout().GetVariables();
  for (const std::size_t variable : variables)
  {
    this->Announced.insert(variable);
    const std::size_t array = all[variable].Array;
    if (!all[variable].IsMagnitude())
    {
      this->Needed.insert(variable);
    }
    else if (!this->IsCached(variable))
    {
      for (int component = 0; component < all.GetComponents(array); ++component)
      {
        this->Needed.insert(all.GetFirst(array) + static_cast<std::size_t>(component));
      }
    }
  }
}

Result<std::shared_ptr<const DecodedBlock>> BlockReading::Get(std::size_t variable)
{
  const Variable& wanted = this->Stores.GetLayout().GetVariables()[variable];
  if (this->Stores.GetLayout().IsInSource(this->Stored))
  {
    // The cache has the chunks, of which a block is soon gathered again.
    return wanted.IsMagnitude() ? this->MakeMagnitude(wanted.Array) : this->ReadComponent(variable);
  }
  bool hit = false;
  auto block = this->Cache.Get(
    this->MakeKey(variable),
    [&]
    {
      return wanted.IsMagnitude() ? this->MakeMagnitude(wanted.Array)
                                  : this->ReadComponent(variable);
    },
    hit);
  this->Statistics.BlockCacheHits += hit && block.IsOk() ? 1 : 0;
  return block;
}

std::size_t BlockReading::FindEndOfRead(std::size_t component) const
{
  std::size_t end = component + 1;
  while (this->Stored.Level == 0 && this->Needed.count(end) != 0 && this->Found.count(end) == 0 &&
    !this->IsCached(end))
  {
    ++end;
  }
  return end;
}

void BlockReading::FindRanges(
  const BlockStore& store, std::vector<StoreRecords::ByteRange>& ranges) const
{
  for (auto component = this->Needed.begin(); component != this->Needed.end();)
  {
    if (this->IsCached(*component))
    {
      ++component;
      continue;
    }
    const std::size_t end = this->FindEndOfRead(*component);
    const auto range =
      store.FindAdjacent(this->Reference.Ordinal, *component, end - *component, this->Stored.Level);
    if (range)
    {
      ranges.push_back(*range);
    }
    component = this->Needed.lower_bound(end);
  }
}

Result<std::shared_ptr<const DecodedBlock>> BlockReading::ReadComponent(std::size_t component)
{
  const auto found = this->Found.find(component);
  if (found != this->Found.end())
  {
    return found->second;
  }
  const std::size_t end = this->FindEndOfRead(component);
  const StoreReplica replica = { static_cast<std::uint32_t>(this->TimeStep), this->Stored.Part,
    this->Reference.Store, this->Reference.Replica };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto blocks,
    this->Stores.ReadReplicas(replica, this->Reference.Ordinal,
      [&](BlockStore& store)
      {
        return store.ReadAdjacent(this->Reference.Ordinal, this->Reference.Block, component,
          end - component, this->Stored.Level, this->Statistics);
      }));
  for (std::size_t n = 0; n < blocks.size(); ++n)
  {
    this->Found[component + n] = blocks[n];
  }
  return blocks.front();
}

/// Components that were not announced do not enter the cache, where they would displace others.
Result<std::shared_ptr<const DecodedBlock>> BlockReading::MakeMagnitude(std::size_t array)
{
  const ArrayVariables& all = this->Stores.GetLayout().GetVariables();
  DecodedBlocks components;
  for (int number = 0; number < all.GetComponents(array); ++number)
  {
    const std::size_t component = all.GetFirst(array) + static_cast<std::size_t>(number);
    ISOSURFACE_ASSIGN_OR_RETURN(const auto block,
      this->Announced.count(component) != 0 || this->IsCached(component)
        ? this->Get(component)
        : this->ReadComponent(component));
    components.push_back(block);
  }
  return std::shared_ptr<const DecodedBlock>(MakeMagnitudeBlock(components));
}

} // namespace isosurface
