// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockStore.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Ground/Volume/SampleRange.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Record/RecordCodec.h"
#include "Storage/Store/SourceSegment.h"

#include <algorithm>
#include <limits>

namespace isosurface
{
namespace
{

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

std::vector<std::string> BlockStore::ListPaths(
  const std::string& folder, const ArrayVariables& variables)
{
  std::vector<std::string> paths = { GetBlocksPath(folder), GetDirectoryPath(folder) };
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
  if (!files.Exists(folder))
  {
    return Status(StatusCode::NotFound, folder + ": this store of the blocked volume is missing");
  }
  std::shared_ptr<BlockStore> store(new BlockStore(files, folder, header, description));
  auto blocks = files.OpenForReading(GetBlocksPath(folder));
  ISOSURFACE_RETURN_IF_ERROR(blocks.GetStatus());
  store->Blocks = std::move(*blocks);
  if (store->Blocks->GetSize() != description.Bytes)
  {
    return Status(StatusCode::Corrupt,
      store->Blocks->GetPath() + ": has " + std::to_string(store->Blocks->GetSize()) +
        " bytes instead of the " + std::to_string(description.Bytes) + " that the header states");
  }
  auto directory = OpenDirectory(files, folder, description,
    store->Variables.GetNumberOfStored() *
      static_cast<std::size_t>(store->Grid.GetNumberOfLevels()),
    source ? SamplePlace::Source : SamplePlace::Store);
  ISOSURFACE_RETURN_IF_ERROR(directory.GetStatus());
  store->Directory = std::move(*directory);
  store->Source = std::move(source);
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
  auto directory = BlockDirectory::Open(files, GetDirectoryPath(folder), description.Blocks,
    segments, description.Checksum, PageCacheBytes, place);
  ISOSURFACE_RETURN_IF_ERROR(directory.GetStatus());
  if (!description.Seals.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR((*directory)->CheckSeal(description.Seals.front()));
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
    auto opened = ExternalIntervalTree::Open(this->Files, path, PageCacheBytes);
    ISOSURFACE_RETURN_IF_ERROR(opened.GetStatus());
    ISOSURFACE_RETURN_IF_ERROR(CheckTree(**opened, this->Description, variable));
    tree = std::move(*opened);
  }
  return const_cast<const ExternalIntervalTree*>(tree.get());
}

Result<std::vector<std::uint32_t>> BlockStore::FindActive(
  std::size_t variable, const std::vector<double>& isovalues, QueryStatistics& statistics)
{
  const auto tree = this->GetTree(variable);
  ISOSURFACE_RETURN_IF_ERROR(tree.GetStatus());
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

Result<std::vector<std::uint32_t>> BlockStore::FindInside(
  std::size_t variable, const std::vector<double>& isovalues, QueryStatistics& statistics)
{
  std::vector<std::uint32_t> ordinals;
  const std::vector<ValueKey> keys = FindThresholdKeys(this->Variables[variable].Type, isovalues);
  const auto tree = this->GetTree(variable);
  ISOSURFACE_RETURN_IF_ERROR(tree.GetStatus());
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
    (*tree)->FindOverlapping(keys.front(), std::numeric_limits<ValueKey>::max(), visit, pages);
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
    ordinal, this->Grid.GetNumberOfBlocks(), this->Blocks->GetSize(), statistics);
}

BlockStore::ByteRange BlockStore::FindRange(
  const BlockDirectoryEntry& entry, std::size_t first, std::size_t count, int level) const
{
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  return { entry.Offset + entry.FindSegment(first * levels),
    entry.Offset + entry.FindSegment((first + count) * levels - static_cast<std::size_t>(level)) };
}

Result<std::int64_t> BlockStore::FindBlock(std::uint32_t ordinal, QueryStatistics& statistics) const
{
  const auto entry = this->FindEntry(ordinal, statistics);
  ISOSURFACE_RETURN_IF_ERROR(entry.GetStatus());
  return entry->Block;
}

Status BlockStore::MakeError(StatusCode code, const std::string& reason) const
{
  return Status(code, this->Blocks->GetPath() + ": " + reason);
}

Result<DecodedBlocks> BlockStore::ReadAdjacent(std::uint32_t ordinal, std::int64_t block,
  std::size_t first, std::size_t count, int level, QueryStatistics& statistics) const
{
  const auto entry = this->FindEntry(ordinal, statistics);
  ISOSURFACE_RETURN_IF_ERROR(entry.GetStatus());
  if (entry->Block != block)
  {
    return this->MakeError(StatusCode::Corrupt,
      "block number " + std::to_string(ordinal) + " is not block " + std::to_string(block));
  }
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  const std::size_t last = first + count - 1;
  for (std::size_t variable = first; variable <= last; ++variable)
  {
    // All components but the last one are read up to level 0.
    ISOSURFACE_RETURN_IF_ERROR(this->CheckLengths(*entry, variable, variable == last ? level : 0));
  }
  const ByteRange range = this->FindRange(*entry, first, count, level);
  Buffer<std::uint8_t> bytes(static_cast<std::size_t>(range.End - range.Begin));
  if (this->Source)
  {
    ISOSURFACE_RETURN_IF_ERROR(
      this->GatherSegments(*entry, first, count, bytes.GetData(), statistics));
  }
  else
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Blocks->Read(range.Begin, bytes.GetSize(), bytes.GetData()));
    ++statistics.BlocksRead;
    statistics.BytesRead += bytes.GetSize();
  }
  DecodedBlocks blocks;
  for (std::size_t variable = first; variable <= last; ++variable)
  {
    const std::uint64_t segment = entry->Offset + entry->FindSegment(variable * levels);
    auto decoded = this->Decode(*entry, variable, level, bytes.GetData() + (segment - range.Begin));
    ISOSURFACE_RETURN_IF_ERROR(decoded.GetStatus());
    blocks.push_back(std::move(*decoded));
  }
  return blocks;
}

Status BlockStore::GatherSegments(const BlockDirectoryEntry& entry, std::size_t first,
  std::size_t count, std::uint8_t* segments, QueryStatistics& statistics) const
{
  constexpr std::size_t headerSize = BlockRecord::SegmentHeaderSize;
  std::vector<std::uint8_t> headers(count * headerSize);
  ISOSURFACE_RETURN_IF_ERROR(
    this->Blocks->Read(entry.Offset + first * headerSize, headers.size(), headers.data()));
  for (std::size_t component = first; component < first + count; ++component)
  {
    ISOSURFACE_RETURN_IF_ERROR(
      GatherSegment(*this->Source, this->Grid, entry, this->Blocks->GetPath(), component,
        headers.data() + (component - first) * headerSize, segments, statistics));
    segments += headerSize + entry.Lengths[component];
  }
  return Status::Ok();
}

std::optional<BlockStore::ByteRange> BlockStore::FindAdjacent(
  std::uint32_t ordinal, std::size_t first, std::size_t count, int level) const
{
  QueryStatistics statistics;
  const auto entry = this->FindEntry(ordinal, statistics);
  if (!entry.IsOk() || this->Source)
  {
    return std::nullopt;
  }
  return this->FindRange(*entry, first, count, level);
}

void BlockStore::Prefetch(const std::vector<ByteRange>& ranges) const
{
  const auto touch = [](const ByteRange& range, const ByteRange& next)
  { return next.Begin <= BlockRecord::AlignUp(range.End); };
  for (auto range = ranges.begin(); range != ranges.end();)
  {
    ByteRange joined = *range++;
    for (; range != ranges.end() && touch(joined, *range); ++range)
    {
      joined.End = std::max(joined.End, range->End);
    }
    this->Blocks->Prefetch(joined.Begin, joined.End - joined.Begin);
  }
}

// Checks lengths of the directory before memory is allocated for them.
Status BlockStore::CheckLengths(
  const BlockDirectoryEntry& entry, std::size_t variable, int level) const
{
  const int levels = this->Grid.GetNumberOfLevels();
  const std::size_t firstSegment = variable * static_cast<std::size_t>(levels);
  for (int from = levels - 1; from >= level; --from)
  {
    const BlockSegment segment(this->Grid, entry.Block, from);
    if (entry.Lengths[firstSegment + static_cast<std::size_t>(levels - 1 - from)] >
      segment.GetNumberOfSamples() * GetValueSize(this->Variables[variable].Type))
    {
      return this->MakeError(StatusCode::Corrupt,
        "block " + std::to_string(entry.Block) + " has an impossible length in the directory");
    }
  }
  return Status::Ok();
}

Result<std::shared_ptr<const DecodedBlock>> BlockStore::Decode(const BlockDirectoryEntry& entry,
  std::size_t variable, int level, const std::uint8_t* segment) const
{
  const int levels = this->Grid.GetNumberOfLevels();
  const std::size_t firstSegment = variable * static_cast<std::size_t>(levels);
  std::vector<const std::uint8_t*> segments;
  std::vector<std::uint32_t> lengths;
  for (std::size_t index = 0; index < static_cast<std::size_t>(levels - level); ++index)
  {
    const std::uint32_t stored = entry.Lengths[firstSegment + index];
    const Status status = CheckSegment(segment, stored,
      { entry.Block, static_cast<std::uint32_t>(variable),
        static_cast<std::uint32_t>(levels - 1) - static_cast<std::uint32_t>(index) });
    if (!status.IsOk())
    {
      return this->MakeError(status.GetCode(), status.GetMessage());
    }
    segments.push_back(segment);
    lengths.push_back(stored);
    segment += BlockRecord::SegmentHeaderSize + stored;
  }
  const auto decoded = DecodeLevel(this->Grid, entry.Block, static_cast<std::uint32_t>(variable),
    level, this->Variables[variable].Type, segments, lengths);
  if (!decoded.IsOk())
  {
    return this->MakeError(decoded.GetStatus().GetCode(), decoded.GetStatus().GetMessage());
  }
  return std::shared_ptr<const DecodedBlock>(*decoded);
}

} // namespace isosurface
