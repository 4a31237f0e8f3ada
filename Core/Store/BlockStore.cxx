// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockStore.h"

#include "Store/BlockRecord.h"
#include "Store/RecordCodec.h"

#include <algorithm>

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

BlockStore::BlockStore(FileSystem& files, std::string folder, const BlockedVolumeHeader& header)
  : Files(files)
  , Folder(std::move(folder))
  , Header(header)
  , Grid(header.GetBlockGrid())
  , Trees(header.Arrays.size())
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
    header.Arrays.size() * static_cast<std::size_t>(store->Grid.GetNumberOfLevels()),
    PageCacheBytes);
  if (!directory.IsOk())
  {
    return directory.GetStatus();
  }
  store->Directory = std::move(*directory);
  return store;
}

Result<const ExternalIntervalTree*> BlockStore::GetTree(std::size_t array)
{
  const std::lock_guard<std::mutex> lock(this->TreeMutex);
  std::unique_ptr<ExternalIntervalTree>& tree = this->Trees[array];
  if (!tree)
  {
    const std::string path = GetTreePath(this->Folder, array);
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
  std::size_t array, const std::vector<double>& isovalues, QueryStatistics& statistics)
{
  const auto tree = this->GetTree(array);
  if (!tree.IsOk())
  {
    return tree.GetStatus();
  }
  std::vector<std::uint32_t> ordinals;
  PageStatistics pages;
  Status status;
  for (const ValueKey key : FindThresholdKeys(this->Header.Arrays[array].Type, isovalues))
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

Result<std::shared_ptr<const DecodedBlock>> BlockStore::Read(std::uint32_t ordinal,
  std::int64_t block, std::size_t array, int level, QueryStatistics& statistics) const
{
  const auto entry = this->Directory->Read(
    ordinal, this->Grid.GetNumberOfBlocks(), this->Blocks->GetSize(), statistics);
  if (!entry.IsOk())
  {
    return entry.GetStatus();
  }
  const auto fail = [&](StatusCode code, const std::string& reason)
  { return Status(code, this->Blocks->GetPath() + ": " + reason); };
  if (entry->Block != block)
  {
    return fail(StatusCode::Corrupt,
      "block number " + std::to_string(ordinal) + " is not block " + std::to_string(block));
  }
  const ValueType type = this->Header.Arrays[array].Type;
  const int levels = this->Grid.GetNumberOfLevels();
  const std::size_t firstSegment = array * static_cast<std::size_t>(levels);
  const std::size_t segmentCount = static_cast<std::size_t>(levels - level);
  for (std::size_t index = 0; index < segmentCount; ++index)
  {
    const BlockSegment segment(this->Grid, block, levels - 1 - static_cast<int>(index));
    if (entry->Lengths[firstSegment + index] > segment.GetNumberOfSamples() * GetValueSize(type))
    {
      return fail(StatusCode::Corrupt,
        "block " + std::to_string(block) + " has an impossible length in the directory");
    }
  }
  const std::uint64_t begin = entry->FindSegment(firstSegment);
  const std::uint64_t size = entry->FindSegment(firstSegment + segmentCount) - begin;
  Buffer<std::uint8_t> bytes(static_cast<std::size_t>(size));
  ISOSURFACE_RETURN_IF_ERROR(
    this->Blocks->Read(entry->Offset + begin, bytes.GetSize(), bytes.GetData()));
  ++statistics.BlocksRead;
  statistics.BytesRead += size;

  std::vector<const std::uint8_t*> segments;
  std::vector<std::uint32_t> lengths;
  const std::uint8_t* segment = bytes.GetData();
  for (std::size_t index = 0; index < segmentCount; ++index)
  {
    const std::uint32_t stored = entry->Lengths[firstSegment + index];
    const Status status = CheckSegment(segment, stored,
      { block, static_cast<std::uint32_t>(array),
        static_cast<std::uint32_t>(levels - 1) - static_cast<std::uint32_t>(index) });
    if (!status.IsOk())
    {
      return fail(status.GetCode(), status.GetMessage());
    }
    segments.push_back(segment);
    lengths.push_back(stored);
    segment += BlockRecord::SegmentHeaderSize + stored;
  }
  const auto decoded = DecodeLevel(
    this->Grid, block, static_cast<std::uint32_t>(array), level, type, segments, lengths);
  if (!decoded.IsOk())
  {
    return fail(decoded.GetStatus().GetCode(), decoded.GetStatus().GetMessage());
  }
  return std::shared_ptr<const DecodedBlock>(*decoded);
}

} // namespace isosurface
