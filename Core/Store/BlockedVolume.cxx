// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockedVolume.h"

#include "Base/Checksum.h"
#include "Store/BlockReading.h"
#include "Store/BlockStore.h"
#include "Store/JsonDocument.h"
#include "Store/VolumeSpectra.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iterator>

namespace isosurface
{
namespace
{

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
  , Variables(header.GetVariables())
{
  std::vector<BlockedVolumeHeader> overviews;
  for (std::size_t overview = 0; overview < header.Overviews.size(); ++overview)
  {
    overviews.push_back(header.MakeOverview(overview));
  }
  this->AddPart(std::move(header));
  for (BlockedVolumeHeader& overview : overviews)
  {
    this->AddPart(std::move(overview));
  }
}

void BlockedVolume::AddPart(BlockedVolumeHeader header)
{
  auto part = std::make_unique<Part>();
  part->FirstLevel = this->Parts.empty() ? 0 : this->GetNumberOfLevels();
  part->Header = std::move(header);
  part->Grid = part->Header.GetBlockGrid();
  for (const TimeStepDescription& step : part->Header.TimeSteps)
  {
    part->Identities.push_back(ComputeIdentity(this->Path, step));
  }
  part->Spectra.resize(part->Header.TimeSteps.size());
  this->Parts.push_back(std::move(part));
}

BlockedVolume::~BlockedVolume() = default;

Result<std::shared_ptr<BlockedVolume>> BlockedVolume::Open(
  const std::string& path, FileSystem& fileSystem, std::shared_ptr<BlockCache> cache)
{
  auto text = BlockedVolumeHeader::ReadText(fileSystem, path);
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

int BlockedVolume::GetNumberOfLevels() const
{
  return this->Parts.back()->FirstLevel + this->Parts.back()->Grid.GetNumberOfLevels();
}

StoredLevel BlockedVolume::FindLevel(int level) const
{
  std::uint32_t part = 0;
  while (part + 1 < this->Parts.size() && this->Parts[part + 1]->FirstLevel <= level)
  {
    ++part;
  }
  return { part, level - this->Parts[part]->FirstLevel, &this->Parts[part]->Grid };
}

int BlockedVolume::GetSpectrumLevel(int level) const
{
  return level - this->FindLevel(level).Level;
}

Status BlockedVolume::CheckArguments(std::size_t timeStep, std::size_t variable, int level) const
{
  const BlockedVolumeHeader& header = this->GetHeader();
  if (timeStep >= header.TimeSteps.size() || variable >= this->Variables.GetCount() || level < 0 ||
    level >= this->GetNumberOfLevels())
  {
    return Status(StatusCode::InvalidArgument,
      this->Path + ": has no time step " + std::to_string(timeStep) + ", no variable " +
        std::to_string(variable) + " or no level " + std::to_string(level));
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
  const auto text = BlockedVolumeHeader::ReadText(this->Files, this->Path);
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
        if (HasSameContents(step, this->GetHeader().TimeSteps[timeStep]))
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
  std::size_t timeStep, std::uint32_t part, std::uint32_t store)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  for (auto open = this->OpenStores.begin(); open != this->OpenStores.end(); ++open)
  {
    if (open->TimeStep == timeStep && open->Part == part && open->Index == store)
    {
      this->OpenStores.splice(this->OpenStores.begin(), this->OpenStores, open);
      return open->Store;
    }
  }
  const BlockedVolumeHeader& header = this->Parts[part]->Header;
  const TimeStepDescription& step = header.TimeSteps[timeStep];
  auto opened = BlockStore::Open(
    this->Files, GetStoreFolder(this->Path, step.Folder, store), header, step.Stores[store]);
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
  this->OpenStores.push_front({ timeStep, part, store, *opened });
  return *opened;
}

Result<std::vector<BlockReference>> BlockedVolume::FindActiveBlocks(std::size_t timeStep,
  std::size_t variable, const std::vector<double>& isovalues, int rank, int ranks,
  QueryStatistics& statistics, int level, const BlockSelection& selection)
{
  const Stopwatch stopwatch(statistics.QuerySeconds);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, level));
  ISOSURFACE_RETURN_IF_ERROR(this->CheckRank(rank, ranks));
  const std::uint32_t partIndex = this->FindLevel(level).Part;
  std::vector<BlockReference> references;
  for (const StorePart& part :
    FindParts(this->Parts[partIndex]->Header.NumberOfStores, rank, ranks))
  {
    const auto store = this->GetStore(timeStep, partIndex, part.Store);
    if (!store.IsOk())
    {
      return store.GetStatus();
    }
    if (!selection.IsPlain())
    {
      const auto selected =
        this->SelectBlocks(**store, part.Store, variable, isovalues, selection, level, statistics);
      if (!selected.IsOk())
      {
        ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
        return selected.GetStatus();
      }
      const auto first = selected->begin();
      references.insert(references.end(),
        first + static_cast<std::ptrdiff_t>(part.FindBegin(selected->size())),
        first + static_cast<std::ptrdiff_t>(part.FindEnd(selected->size())));
      continue;
    }
    const auto active = (*store)->FindActive(variable, isovalues, statistics);
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
      references.push_back({ *block, part.Store, ordinal, partIndex });
    }
  }
  statistics.ActiveBlocks += references.size();
  return references;
}

Result<std::vector<BlockReference>> BlockedVolume::SelectBlocks(BlockStore& store,
  std::uint32_t number, std::size_t variable, const std::vector<double>& isovalues,
  const BlockSelection& selection, int level, QueryStatistics& statistics)
{
  const auto active = store.FindActive(variable, isovalues, statistics);
  if (!active.IsOk())
  {
    return active.GetStatus();
  }
  std::vector<std::uint32_t> candidates = *active;
  if (!selection.ClosedSides.IsEmpty())
  {
    const auto inside = store.FindInside(variable, isovalues, statistics);
    if (!inside.IsOk())
    {
      return inside.GetStatus();
    }
    candidates.clear();
    std::set_union(active->begin(), active->end(), inside->begin(), inside->end(),
      std::back_inserter(candidates));
  }
  const GridGeometry geometry = this->GetHeader().Grid.Coarsen(level);
  const StoredLevel stored = this->FindLevel(level);
  std::vector<BlockReference> references;
  for (const std::uint32_t ordinal : candidates)
  {
    const auto block = store.FindBlock(ordinal, statistics);
    if (!block.IsOk())
    {
      return block.GetStatus();
    }
    const bool isCrossed = std::binary_search(active->begin(), active->end(), ordinal);
    if (selection.Selects(geometry, stored.Grid->GetVertices(*block, stored.Level), isCrossed))
    {
      references.push_back({ *block, number, ordinal, stored.Part });
    }
  }
  return references;
}

Result<std::vector<BlockReference>> BlockedVolume::GetShare(
  std::size_t timeStep, int rank, int ranks, QueryStatistics& statistics, int level)
{
  const Stopwatch stopwatch(statistics.QuerySeconds);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, 0, level));
  ISOSURFACE_RETURN_IF_ERROR(this->CheckRank(rank, ranks));
  const std::uint32_t partIndex = this->FindLevel(level).Part;
  std::vector<BlockReference> references;
  for (const StorePart& part :
    FindParts(this->Parts[partIndex]->Header.NumberOfStores, rank, ranks))
  {
    const auto store = this->GetStore(timeStep, partIndex, part.Store);
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
      references.push_back({ *block, part.Store, ordinal, partIndex });
    }
  }
  return references;
}

Result<std::shared_ptr<const DecodedBlock>> BlockedVolume::ReadBlock(
  const BlockReference& reference, std::size_t timeStep, std::size_t variable, int level,
  QueryStatistics& statistics)
{
  const auto blocks = this->ReadVariables(reference, timeStep, { variable }, level, statistics);
  if (!blocks.IsOk())
  {
    return blocks.GetStatus();
  }
  return blocks->front();
}

BlockCacheKey BlockedVolume::MakeKey(
  std::int64_t block, std::size_t timeStep, std::size_t variable, const StoredLevel& stored) const
{
  return { this->Parts[stored.Part]->Identities[timeStep], block,
    static_cast<std::uint32_t>(variable), static_cast<std::uint32_t>(stored.Level) };
}

void BlockedVolume::Expect(const std::vector<BlockReference>& blocks, std::size_t timeStep,
  const std::vector<std::size_t>& variables, int level)
{
  const StoredLevel stored = this->FindLevel(level);
  std::vector<BlockCacheKey> keys;
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
  QueryStatistics nothing;
  while (begin < std::min(end, blocks.size()))
  {
    const std::uint32_t number = blocks[begin].Store;
    const auto store = this->GetStore(timeStep, stored.Part, number);
    std::vector<BlockStore::ByteRange> ranges;
    for (; begin < end && blocks[begin].Store == number; ++begin)
    {
      if (store.IsOk())
      {
        BlockReading reading(*this, blocks[begin], timeStep, stored, nothing);
        reading.Announce(variables);
        reading.FindRanges(**store, ranges);
      }
    }
    if (store.IsOk())
    {
      (*store)->Prefetch(ranges);
    }
  }
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
  const Part& part = *this->Parts[stored.Part];
  if (reference.Part != stored.Part || reference.Store >= part.Header.NumberOfStores ||
    reference.Block < 0 || reference.Block >= part.Grid.GetNumberOfBlocks())
  {
    return Status(StatusCode::InvalidArgument,
      this->Path + ": has no block " + std::to_string(reference.Block) + " in store " +
        std::to_string(reference.Store) + " at level " + std::to_string(level));
  }
  BlockReading reading(*this, reference, timeStep, stored, statistics);
  reading.Announce(variables);
  DecodedBlocks blocks;
  for (const std::size_t variable : variables)
  {
    auto block = reading.Get(variable);
    if (!block.IsOk())
    {
      return block.GetStatus();
    }
    blocks.push_back(std::move(*block));
  }
  return blocks;
}

std::uint64_t BlockedVolume::EstimateBytes(std::size_t variable, int level) const
{
  // The volume of a sum of boxes is the product of the sums over the axes. On an axis all blocks
  // are alike but for the first one and the last two: a header may promise billions of them.
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
  return samples * GetValueSize(this->Variables[variable].Type);
}

Result<std::shared_ptr<const VolumeSpectra>> BlockedVolume::GetSpectra(
  std::size_t timeStep, std::uint32_t part)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const BlockedVolumeHeader& header = this->Parts[part]->Header;
  std::shared_ptr<const VolumeSpectra>& kept = this->Parts[part]->Spectra[timeStep];
  if (!kept)
  {
    auto spectra = VolumeSpectra::Read(this->Files, this->Path, header.TimeSteps[timeStep].Folder,
      this->Variables.GetCount(), header.NumberOfStores);
    ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
    if (!spectra.IsOk())
    {
      return spectra.GetStatus();
    }
    kept = *spectra;
  }
  return kept;
}

Result<std::shared_ptr<const WorkloadSpectrum>> BlockedVolume::GetSpectrum(
  std::size_t timeStep, std::size_t variable, int level)
{
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, level));
  const auto spectra = this->GetSpectra(timeStep, this->FindLevel(level).Part);
  if (!spectra.IsOk())
  {
    return spectra.GetStatus();
  }
  return (*spectra)->GetTotal(variable);
}

Result<std::shared_ptr<const WorkloadSpectrum>> BlockedVolume::GetStoreSpectrum(
  std::size_t timeStep, std::size_t variable, std::uint32_t store)
{
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, 0));
  const auto spectra = this->GetSpectra(timeStep, 0);
  if (!spectra.IsOk())
  {
    return spectra.GetStatus();
  }
  if (store >= this->GetHeader().NumberOfStores)
  {
    return Status(
      StatusCode::InvalidArgument, this->Path + ": has no store " + std::to_string(store));
  }
  auto spectrum = (*spectra)->GetStore(variable, store);
  if (!spectrum.IsOk())
  {
    ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
  }
  return spectrum;
}

Result<double> BlockedVolume::EstimateTriangles(
  std::size_t timeStep, std::size_t variable, double isovalue, int level)
{
  const auto count = [&](int ofLevel) -> Result<double>
  {
    const auto spectrum = this->GetSpectrum(timeStep, variable, ofLevel);
    if (!spectrum.IsOk())
    {
      return spectrum.GetStatus();
    }
    const std::vector<std::uint64_t>& triangles = (*spectrum)->Triangles;
    return triangles.empty() ? 0.0 : static_cast<double>(triangles[(*spectrum)->FindBin(isovalue)]);
  };
  ISOSURFACE_RETURN_IF_ERROR(this->CheckArguments(timeStep, variable, level));
  const StoredLevel stored = this->FindLevel(level);
  const auto finer = count(level);
  if (!finer.IsOk() || stored.Level == 0)
  {
    return finer;
  }
  if (stored.Part + 1 == this->Parts.size())
  {
    return std::ldexp(*finer, -2 * stored.Level);
  }
  const auto coarser = count(this->Parts[stored.Part + 1]->FirstLevel);
  if (!coarser.IsOk() || *coarser <= 0 || *finer <= 0)
  {
    return coarser.IsOk() ? Result<double>(std::ldexp(*finer, -2 * stored.Level)) : coarser;
  }
  const double share =
    static_cast<double>(stored.Level) / static_cast<double>(stored.Grid->GetNumberOfLevels());
  return *finer * std::pow(*coarser / *finer, share);
}

} // namespace isosurface
