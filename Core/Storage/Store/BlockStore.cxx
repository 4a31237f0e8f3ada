// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockStore.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Ground/Volume/SampleRange.h"

#include <algorithm>
#include <limits>

namespace isosurface
{
std::string BlockStore::GetTreePath(
  const std::string& folder, const ArrayVariables& variables, std::size_t variable)
{
  const Variable& named = variables[variable];
  std::string name = folder + "/array-" + std::to_string(named.Array);
  if (named.IsMagnitude())
  {
    name += "-magnitude";
  }
  else if (variables.GetComponents(named.Array) > 1)
  {
    name += "-component-" + std::to_string(named.Component);
  }
  return name + ".tree";
}

std::vector<std::string> BlockStore::ListPaths(
  const std::string& folder, const ArrayVariables& variables)
{
  std::vector<std::string> paths = { StoreRecords::GetPath(folder), GetDirectoryPath(folder) };
  for (std::size_t variable = 0; variable < variables.GetCount(); ++variable)
  {
    paths.push_back(GetTreePath(folder, variables, variable));
  }
  return paths;
}

std::uint64_t BlockStore::GetTreeIdentity(const StoreDescription& description, std::size_t variable)
{
  std::uint8_t bytes[8];
  StoreLittleEndian(bytes, description.Checksum);
  return ComputeChecksum(bytes, sizeof(bytes), variable);
}

BlockStore::BlockStore(FileSystem& files, std::string folder, const BlockedVolumeHeader& header,
  const StoreDescription& description)
  : Files(files)
  , Folder(std::move(folder))
  , Description(description)
  , Variables(header.GetVariables())
  , Grid(header.GetBlockGrid())
  , Trees(Variables.GetCount())
{
}

Result<std::shared_ptr<BlockStore>> BlockStore::Open(FileSystem& files, const std::string& folder,
  const BlockedVolumeHeader& header, const StoreDescription& description,
  std::shared_ptr<SourceSamples> source)
{
  if (!IsAddress(folder) && !files.Exists(folder))
  {
    return Status(StatusCode::NotFound, folder + ": this store of the blocked volume is missing");
  }
  std::shared_ptr<BlockStore> store(new BlockStore(files, folder, header, description));
  const SamplePlace place = source ? SamplePlace::Source : SamplePlace::Store;
  ISOSURFACE_ASSIGN_OR_RETURN(
    store->Records, StoreRecords::Open(files, folder, header, std::move(source)));
  if (store->Records->GetSize() != description.Bytes)
  {
    return Status(StatusCode::Corrupt,
      store->Records->GetPath() + ": has " + std::to_string(store->Records->GetSize()) +
        " bytes instead of the " + std::to_string(description.Bytes) + " that the header states");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(store->Directory,
    OpenDirectory(files, folder, description,
      store->Variables.GetNumberOfStored() *
        static_cast<std::size_t>(store->Grid.GetNumberOfLevels()),
      place));
  return store;
}

Status BlockStore::CheckTree(
  const ExternalIntervalTree& tree, const StoreDescription& description, std::size_t variable)
{
  if (tree.GetCount() != description.Blocks)
  {
    return tree.MakeCorrupt("has another number of intervals than the store has blocks");
  }
  if (tree.GetIdentity() != GetTreeIdentity(description, variable))
  {
    return tree.MakeCorrupt("it is the tree of another store, array, component or time step");
  }
  return description.Seals.empty() ? Status::Ok() : tree.CheckSeal(description.Seals[1 + variable]);
}

Result<std::unique_ptr<BlockDirectory>> BlockStore::OpenDirectory(FileSystem& files,
  const std::string& folder, const StoreDescription& description, std::size_t segments,
  SamplePlace place)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto directory,
    BlockDirectory::Open(files, GetDirectoryPath(folder), description.Blocks, segments,
      description.Checksum, PageCacheBytes, place));
  if (!description.Seals.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(directory->CheckSeal(description.Seals.front()));
  }
  return directory;
}

Result<const ExternalIntervalTree*> BlockStore::GetTree(std::size_t variable)
{
  const std::lock_guard<std::mutex> lock(this->TreeMutex);
  std::unique_ptr<ExternalIntervalTree>& tree = this->Trees[variable];
  if (!tree)
  {
    const std::string path = GetTreePath(this->Folder, this->Variables, variable);
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto opened, ExternalIntervalTree::Open(this->Files, path, PageCacheBytes));
    ISOSURFACE_RETURN_IF_ERROR(CheckTree(*opened, this->Description, variable));
    tree = std::move(opened);
  }
  return const_cast<const ExternalIntervalTree*>(tree.get());
}

Result<std::vector<std::uint32_t>> BlockStore::FindActive(
  std::size_t variable, const std::vector<double>& isovalues, QueryStatistics& statistics)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto tree, this->GetTree(variable));
  std::vector<std::uint32_t> ordinals;
  PageStatistics pages;
  Status status;
  for (const ValueKey key : FindThresholdKeys(this->Variables[variable].Type, isovalues))
  {
    const auto visit = [&](const KeyInterval& interval)
    {
      ++statistics.IntervalsReported;
      // The tree's intervals are closed, but a block whose minimum is inside is inside as a whole.
      if (interval.Minimum != key)
      {
        ordinals.push_back(interval.Payload);
      }
    };
    status = tree->FindStabbed(key, visit, pages);
    if (!status.IsOk())
    {
      break;
    }
  }
  statistics.TreePagesRead += pages.PageReads;
  statistics.TreePageCacheHits += pages.CacheHits;
  ISOSURFACE_RETURN_IF_ERROR(status);
  std::sort(ordinals.begin(), ordinals.end());
  ordinals.erase(std::unique(ordinals.begin(), ordinals.end()), ordinals.end());
  return ordinals;
}

Result<std::vector<std::uint32_t>> BlockStore::FindInside(
  std::size_t variable, const std::vector<double>& isovalues, QueryStatistics& statistics)
{
  std::vector<std::uint32_t> ordinals;
  const std::vector<ValueKey> keys = FindThresholdKeys(this->Variables[variable].Type, isovalues);
  ISOSURFACE_ASSIGN_OR_RETURN(const auto tree, this->GetTree(variable));
  if (keys.empty())
  {
    return ordinals;
  }
  // Whatever is inside for a higher isovalue is inside for the minimum one.
  PageStatistics pages;
  const auto visit = [&](const KeyInterval& interval)
  {
    ++statistics.IntervalsReported;
    if (interval.Minimum >= keys.front())
    {
      ordinals.push_back(interval.Payload);
    }
  };
  const Status status =
    tree->FindOverlapping(keys.front(), std::numeric_limits<ValueKey>::max(), visit, pages);
  statistics.TreePagesRead += pages.PageReads;
  statistics.TreePageCacheHits += pages.CacheHits;
  ISOSURFACE_RETURN_IF_ERROR(status);
  std::sort(ordinals.begin(), ordinals.end());
  return ordinals;
}

Result<BlockDirectoryEntry> BlockStore::FindEntry(
  std::uint32_t ordinal, QueryStatistics& statistics) const
{
  return this->Directory->Read(
    ordinal, this->Grid.GetNumberOfBlocks(), this->Records->GetSize(), statistics);
}

Result<std::int64_t> BlockStore::FindBlock(std::uint32_t ordinal, QueryStatistics& statistics) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto entry, this->FindEntry(ordinal, statistics));
  return entry.Block;
}

Result<DecodedBlocks> BlockStore::ReadAdjacent(std::uint32_t ordinal, std::int64_t block,
  std::size_t first, std::size_t count, int level, QueryStatistics& statistics) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto entry, this->FindEntry(ordinal, statistics));
  return entry.Block == block
    ? this->Records->Read(entry, first, count, level, statistics)
    : Status(StatusCode::Corrupt,
        this->Records->GetPath() + ": block number " + std::to_string(ordinal) + " is not block " +
          std::to_string(block));
}

std::optional<StoreRecords::ByteRange> BlockStore::FindAdjacent(
  std::uint32_t ordinal, std::size_t first, std::size_t count, int level) const
{
  QueryStatistics statistics;
  const auto entry = this->FindEntry(ordinal, statistics);
  if (!entry.IsOk() || this->Records->AreInSource())
  {
    return std::nullopt;
  }
  return this->Records->FindRange(*entry, first, count, level);
}

} // namespace isosurface
