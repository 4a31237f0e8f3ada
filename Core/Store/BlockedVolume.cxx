// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockedVolume.h"

#include "Base/Checksum.h"
#include "Store/BlockStore.h"
#include "Store/JsonDocument.h"
#include "Store/VolumeSpectra.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>

namespace isosurface
{
namespace
{

constexpr std::uint64_t MaximumHeaderSize = std::uint64_t{ 1 } << 30;
/// Each has a few files open; a process has about a thousand.
constexpr std::size_t MaximumOpenStores = 64;

/// Adds the time until its end to a sum.
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

/// A rank's part of a store: the Index-th of Count equal parts.
struct StorePart
{
  std::uint32_t Store;
  std::uint64_t Index;
  std::uint64_t Count;

  std::uint64_t FindBegin(std::uint64_t size) const { return size * this->Index / this->Count; }
  std::uint64_t FindEnd(std::uint64_t size) const { return size * (this->Index + 1) / this->Count; }
};

std::vector<StorePart> FindParts(std::uint32_t stores, int rank, int ranks)
{
  const auto mine = static_cast<std::uint32_t>(rank);
  const auto all = static_cast<std::uint32_t>(ranks);
  std::vector<StorePart> parts;
  if (all > stores)
  {
    const std::uint32_t store = mine % stores;
    parts.push_back({ store, mine / stores, (all - store + stores - 1) / stores });
    return parts;
  }
  for (std::uint32_t store = mine; store < stores; store += all)
  {
    parts.push_back({ store, 0, 1 });
  }
  return parts;
}

/// Says whose contents a time step's are.
std::uint64_t ComputeIdentity(const std::string& path, const TimeStepDescription& step)
{
  std::error_code error;
  const std::filesystem::path canonical = std::filesystem::weakly_canonical(path, error);
  std::string text = (error ? path : canonical.string()) + "\n" + step.Folder;
  for (const StoreDescription& store : step.Stores)
  {
    text += FormatChecksum(store.Checksum);
  }
  return ComputeChecksum(text.data(), text.size());
}

bool HasSameContents(const TimeStepDescription& a, const TimeStepDescription& b)
{
  bool equal = a.Folder == b.Folder && a.Stores.size() == b.Stores.size();
  for (std::size_t store = 0; equal && store < a.Stores.size(); ++store)
  {
    equal = a.Stores[store].Checksum == b.Stores[store].Checksum &&
      a.Stores[store].Bytes == b.Stores[store].Bytes;
  }
  return equal;
}

} // namespace

BlockedVolume::BlockedVolume(std::string path, FileSystem& files, std::shared_ptr<BlockCache> cache,
  std::string text, BlockedVolumeHeader header)
  : Path(std::move(path))
  , Files(files)
  , Cache(std::move(cache))
  , HeaderText(std::move(text))
  , Header(std::move(header))
  , Grid(Header.Grid.GetDimensions(), Header.BlockSize)
  , Spectra(Header.TimeSteps.size())
{
  for (const TimeStepDescription& step : this->Header.TimeSteps)
  {
    this->Identities.push_back(ComputeIdentity(this->Path, step));
  }
}

BlockedVolume::~BlockedVolume() = default;

Result<std::shared_ptr<BlockedVolume>> BlockedVolume::Open(
  const std::string& path, FileSystem& fileSystem, std::shared_ptr<BlockCache> cache)
{
  auto text = ReadText(fileSystem, path, MaximumHeaderSize);
  if (!text.IsOk())
  {
    return text.GetStatus();
  }
  auto header = BlockedVolumeHeader::Parse(*text, path);
  if (!header.IsOk())
  {
    return header.GetStatus();
  }
  return std::shared_ptr<BlockedVolume>(
    new BlockedVolume(path, fileSystem, std::move(cache), std::move(*text), std::move(*header)));
}

Status BlockedVolume::CheckArguments(std::size_t timeStep, std::size_t array) const
{
  if (timeStep >= this->Header.TimeSteps.size() || array >= this->Header.Arrays.size())
  {
    return Status(StatusCode::InvalidArgument,
      this->Path + ": has no time step " + std::to_string(timeStep) + " or no array " +
        std::to_string(array));
  }
  return Status::Ok();
}

Status BlockedVolume::CheckRank(int rank, int ranks) const
{
  if (rank < 0 || rank >= ranks)
  {
    return Status(StatusCode::InvalidArgument,
      this->Path + ": there is no rank " + std::to_string(rank) + " of " + std::to_string(ranks));
  }
  return Status::Ok();
}

Status BlockedVolume::CheckNotRewritten(std::size_t timeStep) const
{
  const auto text = ReadText(this->Files, this->Path, MaximumHeaderSize);
  if (text.IsOk() && *text == this->HeaderText)
  {
    return Status::Ok();
  }
  if (text.IsOk())
  {
    // Another time step may have been appended; this one is what matters.
    const auto header = BlockedVolumeHeader::Parse(*text, this->Path);
    if (header.IsOk())
    {
      for (const TimeStepDescription& step : header->TimeSteps)
      {
        if (HasSameContents(step, this->Header.TimeSteps[timeStep]))
        {
          return Status::Ok();
        }
      }
    }
  }
  return Status(
    StatusCode::NotFound, this->Path + ": was rewritten or removed since it was opened; reload it");
}

Result<std::shared_ptr<BlockStore>> BlockedVolume::GetStore(
  std::size_t timeStep, std::uint32_t store)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  for (auto open = this->OpenStores.begin(); open != this->OpenStores.end(); ++open)
  {
    if (open->TimeStep == timeStep && open->Index == store)
    {
      this->OpenStores.splice(this->OpenStores.begin(), this->OpenStores, open);
      return open->Store;
    }
  }
  const TimeStepDescription& step = this->Header.TimeSteps[timeStep];
  auto opened = BlockStore::Open(
    this->Files, GetStoreFolder(this->Path, step.Folder, store), this->Header, step.Stores[store]);
  // A rewritten dataset explains whatever is wrong; and one whose folder has the old name, too,
  // would go unnoticed.
  ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
  if (!opened.IsOk())
  {
    return opened.GetStatus();
  }
  if (this->OpenStores.size() == MaximumOpenStores)
  {
    this->OpenStores.pop_back();
  }
  this->OpenStores.push_front({ timeStep, store, *opened });
  return *opened;
}

Result<std::vector<BlockReference>> BlockedVolume::FindActiveBlocks(std::size_t timeStep,
  std::size_t array, const std::vector<double>& isovalues, int rank, int ranks,
  QueryStatistics& statistics)
{
  const Stopwatch stopwatch(statistics.QuerySeconds);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, array));
  ISOSURFACE_RETURN_IF_ERROR(this->CheckRank(rank, ranks));
  std::vector<BlockReference> references;
  for (const StorePart& part : FindParts(this->Header.NumberOfStores, rank, ranks))
  {
    const auto store = this->GetStore(timeStep, part.Store);
    if (!store.IsOk())
    {
      return store.GetStatus();
    }
    const auto active = (*store)->FindActive(array, isovalues, statistics);
    if (!active.IsOk())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
      return active.GetStatus();
    }
    const std::uint64_t end = part.FindEnd(active->size());
    for (std::uint64_t index = part.FindBegin(active->size()); index < end; ++index)
    {
      const std::uint32_t ordinal = (*active)[index];
      const auto block = (*store)->FindBlock(ordinal, statistics);
      if (!block.IsOk())
      {
        return block.GetStatus();
      }
      references.push_back({ *block, part.Store, ordinal });
    }
  }
  statistics.ActiveBlocks += references.size();
  return references;
}

Result<std::vector<BlockReference>> BlockedVolume::GetShare(
  std::size_t timeStep, int rank, int ranks, QueryStatistics& statistics)
{
  const Stopwatch stopwatch(statistics.QuerySeconds);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, 0));
  ISOSURFACE_RETURN_IF_ERROR(this->CheckRank(rank, ranks));
  std::vector<BlockReference> references;
  for (const StorePart& part : FindParts(this->Header.NumberOfStores, rank, ranks))
  {
    const auto store = this->GetStore(timeStep, part.Store);
    if (!store.IsOk())
    {
      return store.GetStatus();
    }
    const std::uint64_t size = (*store)->GetNumberOfBlocks();
    for (std::uint64_t index = part.FindBegin(size); index < part.FindEnd(size); ++index)
    {
      const auto ordinal = static_cast<std::uint32_t>(index);
      const auto block = (*store)->FindBlock(ordinal, statistics);
      if (!block.IsOk())
      {
        return block.GetStatus();
      }
      references.push_back({ *block, part.Store, ordinal });
    }
  }
  return references;
}

Result<std::shared_ptr<const DecodedBlock>> BlockedVolume::ReadBlock(
  const BlockReference& reference, std::size_t timeStep, std::size_t array, int level,
  QueryStatistics& statistics)
{
  const Stopwatch stopwatch(statistics.ReadSeconds);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, array));
  if (level < 0 || level >= this->GetNumberOfLevels() ||
    reference.Store >= this->Header.NumberOfStores || reference.Block < 0 ||
    reference.Block >= this->Grid.GetNumberOfBlocks())
  {
    return Status(StatusCode::InvalidArgument,
      this->Path + ": has no block " + std::to_string(reference.Block) + " in store " +
        std::to_string(reference.Store) + " at level " + std::to_string(level));
  }
  const auto load = [&]() -> Result<std::shared_ptr<const DecodedBlock>>
  {
    const auto store = this->GetStore(timeStep, reference.Store);
    if (!store.IsOk())
    {
      return store.GetStatus();
    }
    return (*store)->Read(reference.Ordinal, reference.Block, array, level, statistics);
  };
  bool hit = false;
  auto block =
    this->Cache->Get({ this->Identities[timeStep], reference.Block,
                       static_cast<std::uint32_t>(array), static_cast<std::uint32_t>(level) },
      load, hit);
  statistics.BlockCacheHits += hit && block.IsOk() ? 1 : 0;
  return block;
}

std::uint64_t BlockedVolume::EstimateBytes(std::size_t array, int level) const
{
  // The volume of a sum of boxes is the product of the sums over the axes. On an axis all blocks
  // are alike but for the first one and the last two: a header may promise billions of them.
  std::uint64_t samples = 1;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t blocks = this->Grid.GetNumberOfBlocksPerAxis()[axis];
    const std::int64_t alike = std::max<std::int64_t>(1, blocks - 3);
    std::uint64_t sum = 0;
    for (std::int64_t index = 0; index < blocks; index += index == 1 ? alike : 1)
    {
      Index3 coordinates = { 0, 0, 0 };
      coordinates[axis] = index;
      const VertexBox box =
        this->Grid.GetGhostedVertices(this->Grid.GetBlockIndex(coordinates), level);
      sum += static_cast<std::uint64_t>(box.GetSize()[axis] * (index == 1 ? alike : 1));
    }
    samples *= sum;
  }
  return samples * GetValueSize(this->Header.Arrays[array].Type);
}

Result<std::shared_ptr<const VolumeSpectra>> BlockedVolume::GetSpectra(std::size_t timeStep)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  if (!this->Spectra[timeStep])
  {
    auto spectra =
      VolumeSpectra::Read(this->Files, this->Path, this->Header.TimeSteps[timeStep].Folder,
        this->Header.Arrays.size(), this->Header.NumberOfStores);
    ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
    if (!spectra.IsOk())
    {
      return spectra.GetStatus();
    }
    this->Spectra[timeStep] = *spectra;
  }
  return this->Spectra[timeStep];
}

Result<std::shared_ptr<const WorkloadSpectrum>> BlockedVolume::GetSpectrum(
  std::size_t timeStep, std::size_t array)
{
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, array));
  const auto spectra = this->GetSpectra(timeStep);
  if (!spectra.IsOk())
  {
    return spectra.GetStatus();
  }
  return (*spectra)->GetTotal(array);
}

Result<std::shared_ptr<const WorkloadSpectrum>> BlockedVolume::GetStoreSpectrum(
  std::size_t timeStep, std::size_t array, std::uint32_t store)
{
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, array));
  const auto spectra = this->GetSpectra(timeStep);
  if (!spectra.IsOk())
  {
    return spectra.GetStatus();
  }
  if (store >= this->Header.NumberOfStores)
  {
    return Status(
      StatusCode::InvalidArgument, this->Path + ": has no store " + std::to_string(store));
  }
  auto spectrum = (*spectra)->GetStore(array, store);
  if (!spectrum.IsOk())
  {
    ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
  }
  return spectrum;
}

} // namespace isosurface
