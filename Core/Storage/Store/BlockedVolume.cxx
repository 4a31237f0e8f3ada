// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockedVolume.h"

#include "Storage/Store/BlockReading.h"
#include "Storage/Store/BlockSearch.h"
#include "Storage/Store/VolumeStores.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <new>
#include <stdexcept>
#include <utility>

namespace isosurface
{
namespace
{

/// Adds the seconds of its lifetime to a sum.
class Stopwatch
{
public:
  explicit Stopwatch(double& sum)
    : Sum(sum)
  {
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch()
  {
    this->Sum +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - this->Begin).count();
  }

private:
  double& Sum;
  std::chrono::steady_clock::time_point Begin = std::chrono::steady_clock::now();
};

/// Runs a step. That there is not enough memory for it is an error like others, so that all ranks
/// can be told.
template <typename Step>
auto RunWithinMemory(const std::string& path, const Step& step) -> decltype(step())
{
  const char* const reason = ": there is not enough memory to read it";
  try
  {
    return step();
  }
  catch (const std::bad_alloc&)
  {
    return Status(StatusCode::OutOfMemory, path + reason);
  }
  catch (const std::length_error&) // more than any memory has
  {
    return Status(StatusCode::OutOfMemory, path + reason);
  }
}

} // namespace

BlockedVolume::BlockedVolume(
  std::unique_ptr<VolumeStores> stores, std::shared_ptr<BlockCache> cache)
  : Stores(std::move(stores))
  , Cache(std::move(cache))
{
  for (const VolumePart& part : this->Stores->GetParts())
  {
    for (const std::uint64_t identity : part.Identities)
    {
      this->Cache->Retain(identity);
    }
  }
}

BlockedVolume::~BlockedVolume()
{
  for (const VolumePart& part : this->Stores->GetParts())
  {
    for (const std::uint64_t identity : part.Identities)
    {
      this->Cache->Release(identity);
    }
  }
}

Result<std::shared_ptr<BlockedVolume>> BlockedVolume::Open(const std::string& path,
  FileSystem& fileSystem, std::shared_ptr<BlockCache> cache, VolumeOpener opener)
{
  return RunWithinMemory(path,
    [&]() -> Result<std::shared_ptr<BlockedVolume>>
    {
      auto text = BlockedVolumeHeader::ReadText(fileSystem, path);
      ISOSURFACE_RETURN_IF_ERROR(text.GetStatus());
      const auto header = BlockedVolumeHeader::Parse(*text, path);
      ISOSURFACE_RETURN_IF_ERROR(header.GetStatus());
      auto stores =
        std::make_unique<VolumeStores>(path, fileSystem, std::move(*text), *header, cache, opener);
      return std::shared_ptr<BlockedVolume>(new BlockedVolume(std::move(stores), std::move(cache)));
    });
}

const std::string& BlockedVolume::GetPath() const
{
  return this->Stores->GetPath();
}

const BlockedVolumeHeader& BlockedVolume::GetHeader() const
{
  return this->Stores->GetHeader();
}

std::uint64_t BlockedVolume::GetFingerprint() const
{
  return this->Stores->GetFingerprint();
}

const ArrayVariables& BlockedVolume::GetVariables() const
{
  return this->Stores->GetVariables();
}

const BlockGrid& BlockedVolume::GetBlockGrid() const
{
  return this->Stores->GetParts().front().Grid;
}

int BlockedVolume::GetNumberOfLevels() const
{
  return this->Stores->GetNumberOfLevels();
}

StoredLevel BlockedVolume::FindLevel(int level) const
{
  return this->Stores->FindLevel(level);
}

const GridLines* BlockedVolume::GetLines(int level) const
{
  return this->Stores->GetLines(level);
}

int BlockedVolume::GetSpectrumLevel(int level) const
{
  return level - this->FindLevel(level).Level;
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

Status BlockedVolume::CheckRank(int rank, int ranks) const
{
  if (rank < 0 || rank >= ranks)
  {
    return Status(StatusCode::InvalidArgument,
      this->GetPath() + ": there is no rank " + std::to_string(rank) + " of " +
        std::to_string(ranks));
  }
  return Status::Ok();
}

Result<std::vector<BlockReference>> BlockedVolume::FindActiveBlocks(std::size_t timeStep,
  std::size_t variable, const std::vector<double>& isovalues, int rank, int ranks,
  QueryStatistics& statistics, int level, const BlockSelection& selection)
{
  const Stopwatch stopwatch(statistics.QuerySeconds);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, level));
  ISOSURFACE_RETURN_IF_ERROR(this->CheckRank(rank, ranks));
  BlockSearch search(*this->Stores, timeStep, level, rank, ranks, this->AreBlocksDealt, statistics);
  return RunWithinMemory(
    this->GetPath(), [&] { return search.FindActive(variable, isovalues, selection); });
}

Result<std::vector<std::vector<BlockReference>>> BlockedVolume::FindActiveShares(
  std::size_t timeStep, std::size_t variable, const std::vector<double>& isovalues, int rank,
  int ranks, QueryStatistics& statistics, int level, const BlockSelection& selection)
{
  const Stopwatch stopwatch(statistics.QuerySeconds);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, level));
  ISOSURFACE_RETURN_IF_ERROR(this->CheckRank(rank, ranks));
  BlockSearch search(*this->Stores, timeStep, level, rank, ranks, true, statistics);
  return RunWithinMemory(
    this->GetPath(), [&] { return search.FindActiveShares(variable, isovalues, selection); });
}

Result<std::vector<BlockReference>> BlockedVolume::GetShare(
  std::size_t timeStep, int rank, int ranks, QueryStatistics& statistics, int level)
{
  const Stopwatch stopwatch(statistics.QuerySeconds);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, 0, level));
  ISOSURFACE_RETURN_IF_ERROR(this->CheckRank(rank, ranks));
  BlockSearch search(*this->Stores, timeStep, level, rank, ranks, false, statistics);
  return RunWithinMemory(this->GetPath(), [&] { return search.FindAll(); });
}

Result<std::shared_ptr<const DecodedBlock>> BlockedVolume::ReadBlock(
  const BlockReference& reference, std::size_t timeStep, std::size_t variable, int level,
  QueryStatistics& statistics)
{
  const auto blocks = this->ReadVariables(reference, timeStep, { variable }, level, statistics);
  ISOSURFACE_RETURN_IF_ERROR(blocks.GetStatus());
  return blocks->front();
}

void BlockedVolume::Expect(const std::vector<BlockReference>& blocks, std::size_t timeStep,
  const std::vector<std::size_t>& variables, int level)
{
  const StoredLevel stored = this->FindLevel(level);
  std::vector<BlockCacheKey> keys;
  if (this->Stores->IsInSource(stored))
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
      keys.push_back(this->Stores->MakeKey(block.Block, timeStep, variable, stored));
    }
  }
  this->Cache->Expect(keys);
}

bool BlockedVolume::IsCached(
  const BlockReference& reference, std::size_t timeStep, std::size_t variable, int level) const
{
  const StoredLevel stored = this->FindLevel(level);
  return this->Cache->Contains(this->Stores->MakeKey(reference.Block, timeStep, variable, stored));
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
    std::map<std::uint32_t, std::vector<const BlockReference*>> replicas;
    for (; begin < end && blocks[begin].Store == number; ++begin)
    {
      const StoreReplica preferred = { static_cast<std::uint32_t>(timeStep), stored.Part, number,
        blocks[begin].Replica };
      replicas[this->Stores->FindReplica(preferred, blocks[begin].Ordinal)].push_back(
        &blocks[begin]);
    }
    for (const auto& [replica, ofReplica] : replicas)
    {
      const auto store = this->Stores->GetStore(timeStep, stored.Part, number, replica);
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
  std::vector<BlockStore::ByteRange> ranges;
  for (const BlockReference* block : blocks)
  {
    BlockReading reading(*this->Stores, *this->Cache, *block, timeStep, stored, nothing);
    reading.Announce(variables);
    reading.FindRanges(store, ranges);
  }
  store.Prefetch(ranges);
}

StoreNews BlockedVolume::ShareStoreFaults(Communicator& ranks)
{
  StoreNews news;
  if (this->GetHeader().NumberOfReplicas == 1)
  {
    return news;
  }
  StoreFaults& faults = this->Stores->GetFaults();
  const std::vector<StoreFault> found = faults.Join(ranks.AllGather(faults.Pack()));
  news.IsNew = !found.empty();
  this->FaultEpoch += found.size();
  news.Warning = this->Stores->DescribeNews(found);
  return news;
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
  const VolumePart& part = this->Stores->GetParts()[stored.Part];
  if (reference.Part != stored.Part || reference.Store >= part.Header.NumberOfStores ||
    reference.Block < 0 || reference.Block >= part.Grid.GetNumberOfBlocks())
  {
    return Status(StatusCode::InvalidArgument,
      this->GetPath() + ": has no block " + std::to_string(reference.Block) + " in store " +
        std::to_string(reference.Store) + " at level " + std::to_string(level));
  }
  return RunWithinMemory(this->GetPath(),
    [&]() -> Result<DecodedBlocks>
    {
      BlockReading reading(*this->Stores, *this->Cache, reference, timeStep, stored, statistics);
      reading.Announce(variables);
      DecodedBlocks blocks;
      for (const std::size_t variable : variables)
      {
        auto block = reading.Get(variable);
        ISOSURFACE_RETURN_IF_ERROR(block.GetStatus());
        blocks.push_back(std::move(*block));
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
  const auto spectra = RunWithinMemory(this->GetPath(),
    [&] { return this->Stores->GetSpectra(timeStep, this->FindLevel(level).Part); });
  ISOSURFACE_RETURN_IF_ERROR(spectra.GetStatus());
  return (*spectra)->GetTotal(variable);
}

Result<std::shared_ptr<const WorkloadSpectrum>> BlockedVolume::GetStoreSpectrum(
  std::size_t timeStep, std::size_t variable, std::uint32_t store)
{
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, 0));
  const auto spectra =
    RunWithinMemory(this->GetPath(), [&] { return this->Stores->GetSpectra(timeStep, 0); });
  ISOSURFACE_RETURN_IF_ERROR(spectra.GetStatus());
  if (store >= this->GetHeader().NumberOfStores)
  {
    return Status(
      StatusCode::InvalidArgument, this->GetPath() + ": has no store " + std::to_string(store));
  }
  auto spectrum = (*spectra)->GetStore(variable, store);
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
    const auto spectrum = this->GetSpectrum(timeStep, variable, ofLevel);
    ISOSURFACE_RETURN_IF_ERROR(spectrum.GetStatus());
    const std::vector<std::uint64_t>& triangles = (*spectrum)->Triangles;
    return triangles.empty() ? 0.0 : static_cast<double>(triangles[(*spectrum)->FindBin(isovalue)]);
  };
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, level));
  const StoredLevel stored = this->FindLevel(level);
  const std::vector<VolumePart>& parts = this->Stores->GetParts();
  auto finer = count(level);
  if (!finer.IsOk() || stored.Level == 0)
  {
    return finer;
  }
  if (stored.Part + 1 == parts.size())
  {
    return std::ldexp(*finer, -2 * stored.Level);
  }
  const auto coarser = count(parts[stored.Part + 1].FirstLevel);
  if (!coarser.IsOk() || *coarser <= 0 || *finer <= 0)
  {
    return coarser.IsOk() ? Result<double>(std::ldexp(*finer, -2 * stored.Level)) : coarser;
  }
  const double share =
    static_cast<double>(stored.Level) / static_cast<double>(stored.Grid->GetNumberOfLevels());
  return *finer * std::pow(*coarser / *finer, share);
}

} // namespace isosurface
