// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockedVolume.h"

#include "Ground/Base/Stopwatch.h"
#include "Ground/Base/WithinMemory.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Record/DecodedBlock.h"
#include "Storage/Store/BlockStore.h"
#include "Storage/Store/StoreRecords.h"
#include "Storage/Store/VolumeStores.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

namespace isosurface
{
namespace
{

/// Reads variables of one block at one level, each through the block cache.
class BlockReading
{
public:
  /// The references must outlive this object.
  BlockReading(VolumeStores& stores, BlockCache& cache, const BlockReference& reference,
    std::size_t timeStep, const StoredLevel& stored, QueryStatistics& statistics)
    : Stores(stores)
    , Cache(cache)
    , Reference(reference)
    , TimeStep(timeStep)
    , Stored(stored)
    , Statistics(statistics)
  {
  }

  /// Declares the variables that Get() will be called for, so that one read can fetch several
  /// components.
  void Announce(const std::vector<std::size_t>& variables)
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

  Result<std::shared_ptr<const DecodedBlock>> Get(std::size_t variable)
  {
    const Variable& wanted = this->Stores.GetLayout().GetVariables()[variable];
    if (this->Stores.GetLayout().IsInSource(this->Stored))
    {
      // The cache has the chunks, of which a block is soon gathered again.
      return wanted.IsMagnitude() ? this->MakeMagnitude(wanted.Array)
                                  : this->ReadComponent(variable);
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

  /// Adds the ranges of bytes that will be read for the announced variables.
  void FindRanges(const BlockStore& store, std::vector<StoreRecords::ByteRange>& ranges) const
  {
    for (auto component = this->Needed.begin(); component != this->Needed.end();)
    {
      if (this->IsCached(*component))
      {
        ++component;
        continue;
      }
      const std::size_t end = this->FindEndOfRead(*component);
      const auto range = store.FindAdjacent(
        this->Reference.Ordinal, *component, end - *component, this->Stored.Level);
      if (range)
      {
        ranges.push_back(*range);
      }
      component = this->Needed.lower_bound(end);
    }
  }

private:
  using Block = std::shared_ptr<const DecodedBlock>;

  BlockCacheKey MakeKey(std::size_t variable) const
  {
    return this->Stores.GetLayout().MakeKey(
      this->Reference.Block, this->TimeStep, variable, this->Stored);
  }
  bool IsCached(std::size_t variable) const
  {
    return this->Cache.Contains(this->MakeKey(variable));
  }
  /// Returns the end of the components from `component` on that one read fetches. At levels
  /// above 0 a read fetches `component` alone, since the bytes between components are not needed.
  std::size_t FindEndOfRead(std::size_t component) const
  {
    std::size_t end = component + 1;
    while (this->Stored.Level == 0 && this->Needed.count(end) != 0 && this->Found.count(end) == 0 &&
      !this->IsCached(end))
    {
      ++end;
    }
    return end;
  }

  /// Also reads the next components of the record, if they are announced.
  Result<Block> ReadComponent(std::size_t component)
  {
    const auto found = this->Found.find(component);
    if (found != this->Found.end())
    {
      return found->second;
    }
    const std::size_t end = this->FindEndOfRead(component);
    const StoreReplica replica = { static_cast<std::uint32_t>(this->TimeStep),
      this->Stored.Overview, this->Reference.Store, this->Reference.Replica };
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
  Result<Block> MakeMagnitude(std::size_t array)
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

  VolumeStores& Stores;
  BlockCache& Cache;
  const BlockReference& Reference;
  std::size_t TimeStep;
  StoredLevel Stored;
  QueryStatistics& Statistics;
  std::set<std::size_t> Announced;    ///< variables
  std::set<std::size_t> Needed;       ///< the components among them, and those of magnitudes
  std::map<std::size_t, Block> Found; ///< components that were read
};

} // namespace
BlockedVolume::BlockedVolume(VolumeLayout layout, FileSystem& files,
  const std::shared_ptr<BlockCache>& cache, VolumeOpener opener)
  : VolumeLayout(std::move(layout))
  , Cache(cache)
  , Stores(std::make_unique<VolumeStores>(*this, files, cache, opener))
{
  for (const std::uint64_t dataset : this->ListDatasets())
  {
    this->Cache->Retain(dataset);
  }
}

BlockedVolume::~BlockedVolume()
{
  for (const std::uint64_t dataset : this->ListDatasets())
  {
    this->Cache->Release(dataset);
  }
}

Result<std::shared_ptr<BlockedVolume>> BlockedVolume::Open(const std::string& path,
  FileSystem& fileSystem, std::shared_ptr<BlockCache> cache, VolumeOpener opener,
  const GridPlace& place)
{
  return RunWithinMemory(path, NoMemoryReason,
    [&]() -> Result<std::shared_ptr<BlockedVolume>>
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto text, BlockedVolumeHeader::ReadText(fileSystem, path));
      ISOSURFACE_ASSIGN_OR_RETURN(auto header, BlockedVolumeHeader::Parse(text, path));
      const std::string stores = GetStoresFolder(fileSystem, path);
      if (!IsAddress(stores) && !fileSystem.Exists(stores)) // of an address, files alone are seen
      {
        return Status(StatusCode::NotFound,
          path + ": its folder " + stores + " is missing; copy or move both together");
      }
      const GridGeometry found = header.Grid;
      ISOSURFACE_RETURN_IF_ERROR(place.Apply(path, header.Lines.has_value(), header.Grid));
      return std::shared_ptr<BlockedVolume>(
        new BlockedVolume({ path, text, std::move(header), found }, fileSystem, cache, opener));
    });
}

Status BlockedVolume::CheckArguments(std::size_t timeStep, std::size_t variable, int level) const
{
  const BlockedVolumeHeader& header = this->GetHeader();
  if (timeStep >= header.TimeSteps.size() || variable >= this->GetVariables().GetCount() ||
    level < 0 || level >= this->GetNumberOfLevels())
  {
    return Status(StatusCode::InvalidArgument,
      this->GetPath() + ": has no time step " + std::to_string(timeStep) + ", no variable " +
        std::to_string(variable) + " or no level " + std::to_string(level));
  }
  return Status::Ok();
}

Result<std::vector<BlockReference>> BlockedVolume::FindActiveBlocks(
  const BlockQuery& query, const StoreSpan& span, int level, QueryStatistics& statistics)
{
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(query.TimeStep, query.Variable, level));
  return RunWithinMemory(this->GetPath(), NoMemoryReason,
    [&]() -> Result<std::vector<BlockReference>>
    {
      const StoreReplica replica = { static_cast<std::uint32_t>(query.TimeStep),
        this->FindLevel(level).Overview, span.Store, span.Replica };
      auto found = this->Stores->ReadReplicas(replica, StoreFault::Whole,
        [&](BlockStore& store)
        { return isosurface::FindActiveBlocks(store, *this, query, span, level, statistics); });
      if (!found.IsOk())
      {
        ISOSURFACE_RETURN_IF_ERROR(this->Stores->CheckNotRewritten(query.TimeStep));
      }
      return found;
    });
}

Result<std::vector<BlockReference>> BlockedVolume::ListBlocks(
  std::size_t timeStep, QueryStatistics& statistics, int level)
{
  const Stopwatch stopwatch(statistics.QuerySeconds);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, 0, level));
  return RunWithinMemory(this->GetPath(), NoMemoryReason,
    [&]() -> Result<std::vector<BlockReference>>
    {
      StoreReplica replica;
      replica.TimeStep = static_cast<std::uint32_t>(timeStep);
      replica.Overview = this->FindLevel(level).Overview;
      const BlockedVolumeHeader& header = this->GetStoredGrids()[replica.Overview].Header;
      std::vector<BlockReference> blocks;
      for (; replica.Store < header.NumberOfStores; ++replica.Store)
      {
        replica.Replica = this->GetFaults().FindBest(replica, header.NumberOfReplicas).front();
        ISOSURFACE_ASSIGN_OR_RETURN(const auto all,
          this->Stores->ReadReplicas(replica, StoreFault::Whole,
            [&](BlockStore& store) {
              return isosurface::ListBlocks(store, replica.Store, replica.Overview, statistics);
            }));
        blocks.insert(blocks.end(), all.begin(), all.end());
      }
      return blocks;
    });
}

Result<StoreWork> BlockedVolume::FindStoreWork(const BlockQuery& query, int level)
{
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(query.TimeStep, query.Variable, level));
  return RunWithinMemory(this->GetPath(), NoMemoryReason,
    [&] { return this->Stores->FindStoreWork(query, this->FindLevel(level).Overview); });
}

const StoreFaults& BlockedVolume::GetFaults() const
{
  return this->Stores->GetFaults();
}

Result<std::shared_ptr<const DecodedBlock>> BlockedVolume::ReadBlock(
  const BlockReference& reference, std::size_t timeStep, std::size_t variable, int level,
  QueryStatistics& statistics)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto blocks, this->ReadVariables(reference, timeStep, { variable }, level, statistics));
  return blocks.front();
}

void BlockedVolume::Expect(const std::vector<BlockReference>& blocks, std::size_t timeStep,
  const std::vector<std::size_t>& variables, int level)
{
  const StoredLevel stored = this->FindLevel(level);
  std::vector<BlockCacheKey> keys;
  if (this->IsInSource(stored))
  {
    // Chunks are in the cache, not blocks; the last ones that were used are needed next.
    this->Cache->Expect(keys);
    return;
  }
  keys.reserve(blocks.size() * variables.size());
  for (const BlockReference& block : blocks)
  {
    for (const std::size_t variable : variables)
    {
      keys.push_back(this->MakeKey(block.Block, timeStep, variable, stored));
    }
  }
  this->Cache->Expect(keys);
}

bool BlockedVolume::IsCached(
  const BlockReference& reference, std::size_t timeStep, std::size_t variable, int level) const
{
  const StoredLevel stored = this->FindLevel(level);
  return this->Cache->Contains(this->MakeKey(reference.Block, timeStep, variable, stored));
}

void BlockedVolume::Prefetch(const std::vector<BlockReference>& blocks, std::size_t begin,
  std::size_t end, std::size_t timeStep, const std::vector<std::size_t>& variables, int level)
{
  const StoredLevel stored = this->FindLevel(level);
  end = std::min(end, blocks.size());
  while (begin < end)
  {
    // Blocks of one store, each in the replica that it will be read from.
    const std::uint32_t number = blocks[begin].Store;
    std::map<StoreReplica, std::vector<const BlockReference*>> replicas;
    for (; begin < end && blocks[begin].Store == number; ++begin)
    {
      StoreReplica replica = { static_cast<std::uint32_t>(timeStep), stored.Overview, number,
        blocks[begin].Replica };
      replica.Replica = this->Stores->FindReplica(replica, blocks[begin].Ordinal);
      replicas[replica].push_back(&blocks[begin]);
    }
    for (const auto& [replica, ofReplica] : replicas)
    {
      const auto store = this->Stores->GetStore(replica);
      if (store.IsOk())
      {
        this->Prefetch(**store, ofReplica, timeStep, variables, stored);
      }
    }
  }
}

void BlockedVolume::Prefetch(const BlockStore& store,
  const std::vector<const BlockReference*>& blocks, std::size_t timeStep,
  const std::vector<std::size_t>& variables, const StoredLevel& stored)
{
  QueryStatistics nothing;
  std::vector<StoreRecords::ByteRange> ranges;
  for (const BlockReference* block : blocks)
  {
    BlockReading reading(*this->Stores, *this->Cache, *block, timeStep, stored, nothing);
    reading.Announce(variables);
    reading.FindRanges(store, ranges);
  }
  store.Prefetch(ranges);
}

int BlockedVolume::ChooseThreads(std::size_t timeStep, int threads) const
{
  const std::optional<SourceRecord>& source = this->GetHeader().TimeSteps[timeStep].Source;
  return ChooseReadingThreads(source ? source->AbsolutePath : this->GetPath(), threads);
}

bool BlockedVolume::IsAtAddress(std::size_t timeStep, std::size_t variable) const
{
  const auto& source = this->GetHeader().TimeSteps[timeStep].Source;
  return source && IsAddress(source->AbsolutePath) && !this->GetVariables()[variable].IsMagnitude();
}

Status BlockedVolume::ReadSource(std::size_t timeStep, std::size_t variable, const VertexBox& box,
  std::uint8_t* to, QueryStatistics& statistics)
{
  return this->Stores->ReadSource(timeStep, variable, box, to, statistics);
}

Status BlockedVolume::CheckSource(std::size_t timeStep)
{
  return this->Stores->CheckSource(timeStep);
}

Result<StoreNews> BlockedVolume::ShareStoreFaults(Communicator& ranks)
{
  StoreNews news;
  if (this->GetHeader().NumberOfReplicas == 1)
  {
    return news;
  }
  StoreFaults& faults = this->Stores->GetFaults();
  const std::string context = this->GetPath() + ": lost stores cannot be told to all ranks";
  return RunCollective(context,
    [&]() -> Result<StoreNews>
    {
      Message mine;
      const auto pack = [&]
      {
        mine = faults.Pack();
        return Status::Ok();
      };
      ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, context, pack));
      const std::vector<Message> all = ranks.AllGather(mine);
      const auto join = [&]
      {
        const std::vector<StoreFault> found = faults.Join(all);
        news.IsNew = !found.empty();
        this->FaultEpoch += found.size();
        news.Warning = this->Stores->DescribeNews(found);
        return Status::Ok();
      };
      ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, context, join));
      return news;
    });
}

Result<DecodedBlocks> BlockedVolume::ReadVariables(const BlockReference& reference,
  std::size_t timeStep, const std::vector<std::size_t>& variables, int level,
  QueryStatistics& statistics)
{
  const Stopwatch stopwatch(statistics.ReadSeconds);
  for (const std::size_t variable : variables)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, level));
  }
  const StoredLevel stored = this->FindLevel(level);
  const StoredGrid& grid = this->GetStoredGrids()[stored.Overview];
  if (reference.Overview != stored.Overview || reference.Store >= grid.Header.NumberOfStores ||
    reference.Block < 0 || reference.Block >= grid.Grid.GetNumberOfBlocks())
  {
    return Status(StatusCode::InvalidArgument,
      this->GetPath() + ": has no block " + std::to_string(reference.Block) + " in store " +
        std::to_string(reference.Store) + " at level " + std::to_string(level));
  }
  return RunWithinMemory(this->GetPath(), NoMemoryReason,
    [&]() -> Result<DecodedBlocks>
    {
      BlockReading reading(*this->Stores, *this->Cache, reference, timeStep, stored, statistics);
      reading.Announce(variables);
      DecodedBlocks blocks;
      for (const std::size_t variable : variables)
      {
        ISOSURFACE_ASSIGN_OR_RETURN(auto block, reading.Get(variable));
        blocks.push_back(std::move(block));
      }
      return blocks;
    });
}

std::uint64_t BlockedVolume::EstimateBytes(std::size_t variable, int level) const
{
  // The boxes' volumes add up to the product of the sums over the axes. On an axis all blocks but
  // the first one and the last two are alike, so billions of them cost no more than four.
  const StoredLevel stored = this->FindLevel(level);
  const BlockGrid& grid = *stored.Grid;
  std::uint64_t samples = 1;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t blocks = grid.GetNumberOfBlocksPerAxis()[axis];
    const std::int64_t alike = std::max<std::int64_t>(1, blocks - 3);
    std::uint64_t sum = 0;
    for (std::int64_t index = 0; index < blocks; index += index == 1 ? alike : 1)
    {
      Index3 coordinates = { 0, 0, 0 };
      coordinates[axis] = index;
      const VertexBox box = grid.GetGhostedVertices(grid.GetBlockIndex(coordinates), stored.Level);
      sum += static_cast<std::uint64_t>(box.GetSize()[axis] * (index == 1 ? alike : 1));
    }
    samples *= sum;
  }
  return samples * GetValueSize(this->GetVariables()[variable].Type);
}

Result<std::shared_ptr<const WorkloadSpectrum>> BlockedVolume::GetSpectrum(
  std::size_t timeStep, std::size_t variable, int level)
{
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, level));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto spectra,
    RunWithinMemory(this->GetPath(), NoMemoryReason,
      [&] { return this->Stores->GetSpectra(timeStep, this->FindLevel(level).Overview); }));
  return spectra->GetTotal(variable);
}

Result<std::shared_ptr<const WorkloadSpectrum>> BlockedVolume::GetStoreSpectrum(
  std::size_t timeStep, std::size_t variable, std::uint32_t store)
{
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, 0));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto spectra,
    RunWithinMemory(
      this->GetPath(), NoMemoryReason, [&] { return this->Stores->GetSpectra(timeStep, 0); }));
  if (store >= this->GetHeader().NumberOfStores)
  {
    return Status(
      StatusCode::InvalidArgument, this->GetPath() + ": has no store " + std::to_string(store));
  }
  auto spectrum = spectra->GetStore(variable, store);
  if (!spectrum.IsOk())
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Stores->CheckNotRewritten(timeStep));
  }
  return spectrum;
}

Result<double> BlockedVolume::EstimateTriangles(
  std::size_t timeStep, std::size_t variable, double isovalue, int level)
{
  const auto count = [&](int ofLevel) -> Result<double>
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto spectrum, this->GetSpectrum(timeStep, variable, ofLevel));
    const std::vector<std::uint64_t>& triangles = spectrum->Triangles;
    return triangles.empty() ? 0.0 : static_cast<double>(triangles[spectrum->FindBin(isovalue)]);
  };
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, level));
  const StoredLevel stored = this->FindLevel(level);
  const std::vector<StoredGrid>& grids = this->GetStoredGrids();
  auto finer = count(level);
  if (!finer.IsOk() || stored.Level == 0)
  {
    return finer;
  }
  if (stored.Overview + 1 == grids.size())
  {
    return std::ldexp(*finer, -2 * stored.Level);
  }
  const auto coarser = count(grids[stored.Overview + 1].FirstLevel);
  if (!coarser.IsOk() || *coarser <= 0 || *finer <= 0)
  {
    return coarser.IsOk() ? Result<double>(std::ldexp(*finer, -2 * stored.Level)) : coarser;
  }
  const double share =
    static_cast<double>(stored.Level) / static_cast<double>(stored.Grid->GetNumberOfLevels());
  return *finer * std::pow(*coarser / *finer, share);
}

} // namespace isosurface
