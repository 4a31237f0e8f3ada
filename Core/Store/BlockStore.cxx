// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockStore.h"

#include "Store/BlockRecord.h"
#include "Store/RecordCodec.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

/// The keys at which the trees are asked; isovalues that nothing can reach have none.
std::vector<ValueKey> FindThresholdKeys(ValueType type, const std::vector<double>& isovalues)
{
  std::vector<ValueKey> keys;
  DispatchValueType(type,
    [&](auto zero)
    {
      for (const double isovalue : isovalues)
      {
        if (const auto threshold = FindThreshold<decltype(zero)>(isovalue))
        {
          keys.push_back(MakeValueKey(*threshold));
        }
      }
    });
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

} // namespace

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

BlockStore::BlockStore(FileSystem& files, std::string folder, const BlockedVolumeHeader& header)
  : Files(files)
  , Folder(std::move(folder))
  , Variables(header.GetVariables())
  , Grid(header.Grid.GetDimensions(), header.BlockSize)
  , Trees(Variables.GetCount())
{
}

Result<std::shared_ptr<BlockStore>> BlockStore::Open(FileSystem& files, const std::string& folder,
  const BlockedVolumeHeader& header, const StoreDescription& description)
{
  if (!files.Exists(folder))
  {
    return Status(StatusCode::NotFound, folder + ": this store of the blocked volume is missing");
  }
  std::shared_ptr<BlockStore> store(new BlockStore(files, folder, header));
  auto blocks = files.OpenForReading(GetBlocksPath(folder));
  if (!blocks.IsOk())
  {
    return blocks.GetStatus();
  }
  store->Blocks = std::move(*blocks);
  if (store->Blocks->GetSize() != description.Bytes)
  {
    return Status(StatusCode::Corrupt,
      store->Blocks->GetPath() + ": has " + std::to_string(store->Blocks->GetSize()) +
        " bytes instead of the " + std::to_string(description.Bytes) + " that the header says");
  }
  auto directory = BlockDirectory::Open(files, GetDirectoryPath(folder), description.Blocks,
    store->Variables.GetNumberOfStored() *
      static_cast<std::size_t>(store->Grid.GetNumberOfLevels()),
    PageCacheBytes);
  if (!directory.IsOk())
  {
    return directory.GetStatus();
  }
  store->Directory = std::move(*directory);
  return store;
}

Result<const ExternalIntervalTree*> BlockStore::GetTree(std::size_t variable)
{
  const std::lock_guard<std::mutex> lock(this->TreeMutex);
  std::unique_ptr<ExternalIntervalTree>& tree = this->Trees[variable];
  if (!tree)
  {
    const std::string path = GetTreePath(this->Folder, this->Variables, variable);
    auto opened = ExternalIntervalTree::Open(this->Files, path, PageCacheBytes);
    if (!opened.IsOk())
    {
      return opened.GetStatus();
    }
    if ((*opened)->GetCount() != this->GetNumberOfBlocks())
    {
      return Status(
        StatusCode::Corrupt, path + ": has another number of intervals than the store has blocks");
    }
    tree = std::move(*opened);
  }
  return const_cast<const ExternalIntervalTree*>(tree.get());
}

Result<std::vector<std::uint32_t>> BlockStore::FindActive(
  std::size_t variable, const std::vector<double>& isovalues, QueryStatistics& statistics)
{
  const auto tree = this->GetTree(variable);
  if (!tree.IsOk())
  {
    return tree.GetStatus();
  }
  std::vector<std::uint32_t> ordinals;
  PageStatistics pages;
  Status status;
  for (const ValueKey key : FindThresholdKeys(this->Variables[variable].Type, isovalues))
  {
    const auto visit = [&](const KeyInterval& interval)
    {
      ++statistics.IntervalsReported;
      // The tree's intervals are closed, but a block whose least value is inside is all inside.
      if (interval.Minimum != key)
      {
        ordinals.push_back(interval.Payload);
      }
    };
    status = (*tree)->FindStabbed(key, visit, pages);
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

Result<std::int64_t> BlockStore::FindBlock(std::uint32_t ordinal, QueryStatistics& statistics) const
{
  const auto entry = this->Directory->Read(
    ordinal, this->Grid.GetNumberOfBlocks(), this->Blocks->GetSize(), statistics);
  if (!entry.IsOk())
  {
    return entry.GetStatus();
  }
  return entry->Block;
}

Status BlockStore::MakeError(StatusCode code, const std::string& reason) const
{
  return Status(code, this->Blocks->GetPath() + ": " + reason);
}

Result<std::shared_ptr<const DecodedBlock>> BlockStore::Read(std::uint32_t ordinal,
  std::int64_t block, std::size_t variable, int level, QueryStatistics& statistics) const
{
  const auto entry = this->Directory->Read(
    ordinal, this->Grid.GetNumberOfBlocks(), this->Blocks->GetSize(), statistics);
  if (!entry.IsOk())
  {
    return entry.GetStatus();
  }
  if (entry->Block != block)
  {
    return this->MakeError(StatusCode::Corrupt,
      "block number " + std::to_string(ordinal) + " is not block " + std::to_string(block));
  }
  const Variable& wanted = this->Variables[variable];
  const std::size_t first =
    wanted.IsMagnitude() ? this->Variables.GetFirst(wanted.Array) : variable;
  const int count = wanted.IsMagnitude() ? this->Variables.GetComponents(wanted.Array) : 1;
  const auto components =
    this->ReadComponents(*entry, first, static_cast<std::size_t>(count), level, statistics);
  if (!components.IsOk())
  {
    return components.GetStatus();
  }
  ++statistics.BlocksRead;
  return std::shared_ptr<const DecodedBlock>(
    wanted.IsMagnitude() ? MakeMagnitudeBlock(*components) : components->front());
}

/// Components that follow each other in the record; all their levels are one piece of it.
Result<std::vector<std::shared_ptr<DecodedBlock>>> BlockStore::ReadComponents(
  const BlockDirectoryEntry& entry, std::size_t first, std::size_t count, int level,
  QueryStatistics& statistics) const
{
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  const std::size_t wanted = levels - static_cast<std::size_t>(level);
  for (std::size_t component = first; component < first + count; ++component)
  {
    const std::size_t valueSize = GetValueSize(this->Variables[component].Type);
    for (std::size_t index = 0; index < wanted; ++index)
    {
      const BlockSegment segment(this->Grid, entry.Block, static_cast<int>(levels - 1 - index));
      if (entry.Lengths[component * levels + index] > segment.GetNumberOfSamples() * valueSize)
      {
        return this->MakeError(StatusCode::Corrupt,
          "block " + std::to_string(entry.Block) + " has an impossible length in the directory");
      }
    }
  }
  std::vector<std::shared_ptr<DecodedBlock>> decoded;
  Buffer<std::uint8_t> bytes;
  std::uint64_t begin = 0;
  for (std::size_t component = first; component < first + count; ++component)
  {
    if (component == first || level > 0)
    {
      const std::size_t last = level > 0 ? component : first + count - 1;
      begin = entry.FindSegment(component * levels);
      const std::uint64_t size = entry.FindSegment(last * levels + wanted) - begin;
      bytes = Buffer<std::uint8_t>(static_cast<std::size_t>(size));
      ISOSURFACE_RETURN_IF_ERROR(
        this->Blocks->Read(entry.Offset + begin, bytes.GetSize(), bytes.GetData()));
      statistics.BytesRead += size;
    }
    const std::uint8_t* segments =
      bytes.GetData() + (entry.FindSegment(component * levels) - begin);
    auto block = this->DecodeComponent(entry, component, level, segments);
    if (!block.IsOk())
    {
      return block.GetStatus();
    }
    decoded.push_back(std::move(*block));
  }
  return decoded;
}

/// `segments`: those of the levels from the coarsest to `level`, as they are on disk.
Result<std::shared_ptr<DecodedBlock>> BlockStore::DecodeComponent(const BlockDirectoryEntry& entry,
  std::size_t component, int level, const std::uint8_t* segments) const
{
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  std::vector<const std::uint8_t*> bytes;
  std::vector<std::uint32_t> lengths;
  for (std::size_t index = 0; index < levels - static_cast<std::size_t>(level); ++index)
  {
    const std::uint32_t stored = entry.Lengths[component * levels + index];
    const Status status = CheckSegment(segments, stored,
      { entry.Block, static_cast<std::uint32_t>(component),
        static_cast<std::uint32_t>(levels - 1 - index) });
    if (!status.IsOk())
    {
      return this->MakeError(status.GetCode(), status.GetMessage());
    }
    bytes.push_back(segments);
    lengths.push_back(stored);
    segments += BlockRecord::SegmentHeaderSize + stored;
  }
  auto decoded = DecodeLevel(this->Grid, entry.Block, static_cast<std::uint32_t>(component), level,
    this->Variables[component].Type, bytes, lengths);
  return decoded.IsOk()
    ? std::move(decoded)
    : this->MakeError(decoded.GetStatus().GetCode(), decoded.GetStatus().GetMessage());
}

} // namespace isosurface
