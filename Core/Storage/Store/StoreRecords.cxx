// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/StoreRecords.h"

#include "Ground/Base/Buffer.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Record/RecordCodec.h"
#include "Storage/Store/SourceSamples.h"

#include <algorithm>
#include <utility>

namespace isosurface
{

Result<std::unique_ptr<StoreRecords>> StoreRecords::Open(FileSystem& files,
  const std::string& folder, const BlockedVolumeHeader& header,
  std::shared_ptr<SourceSamples> source)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, files.OpenForReading(GetPath(folder)));
  return std::unique_ptr<StoreRecords>(
    new StoreRecords(std::move(file), header, std::move(source)));
}

StoreRecords::StoreRecords(std::unique_ptr<RandomAccessFile> file,
  const BlockedVolumeHeader& header, std::shared_ptr<SourceSamples> source)
  : File(std::move(file))
  , Variables(header.GetVariables())
  , Grid(header.GetBlockGrid())
  , Source(std::move(source))
{
}

StoreRecords::ByteRange StoreRecords::FindRange(
  const BlockDirectoryEntry& entry, std::size_t first, std::size_t count, int level) const
{
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  return { entry.Offset + entry.FindSegment(first * levels),
    entry.Offset + entry.FindSegment((first + count) * levels - static_cast<std::size_t>(level)) };
}

Status StoreRecords::MakeError(StatusCode code, const std::string& reason) const
{
  return Status(code, this->File->GetPath() + ": " + reason);
}

// Checks lengths of the directory before memory is allocated for them.
Status StoreRecords::CheckLengths(
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

Result<DecodedBlocks> StoreRecords::Read(const BlockDirectoryEntry& entry, std::size_t first,
  std::size_t count, int level, QueryStatistics& statistics) const
{
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  const std::size_t last = first + count - 1;
  for (std::size_t variable = first; variable <= last; ++variable)
  {
    // All components but the last one are read up to level 0.
    ISOSURFACE_RETURN_IF_ERROR(this->CheckLengths(entry, variable, variable == last ? level : 0));
  }
  if (this->Source)
  {
    return this->Gather(entry, first, count, statistics);
  }
  const ByteRange range = this->FindRange(entry, first, count, level);
  Buffer<std::uint8_t> bytes(static_cast<std::size_t>(range.End - range.Begin));
  ISOSURFACE_RETURN_IF_ERROR(this->File->Read(range.Begin, bytes.GetSize(), bytes.GetData()));
  ++statistics.BlocksRead;
  statistics.BytesRead += bytes.GetSize();
  DecodedBlocks blocks;
  for (std::size_t variable = first; variable <= last; ++variable)
  {
    const std::uint64_t segment = entry.Offset + entry.FindSegment(variable * levels);
    ISOSURFACE_ASSIGN_OR_RETURN(auto decoded,
      this->Decode(entry, variable, level, bytes.GetData() + (segment - range.Begin)));
    blocks.push_back(std::move(decoded));
  }
  return blocks;
}

Result<DecodedBlocks> StoreRecords::Gather(const BlockDirectoryEntry& entry, std::size_t first,
  std::size_t count, QueryStatistics& statistics) const
{
  constexpr std::size_t headerSize = BlockRecord::SegmentHeaderSize;
  std::vector<std::uint8_t> headers(count * headerSize);
  ISOSURFACE_RETURN_IF_ERROR(
    this->File->Read(entry.Offset + first * headerSize, headers.size(), headers.data()));
  DecodedBlocks blocks;
  for (std::size_t number = 0; number < count; ++number)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto block,
      GatherBlock(*this->Source, this->Grid, entry, this->File->GetPath(), first + number,
        headers.data() + number * headerSize, statistics));
    blocks.push_back(std::move(block));
  }
  return blocks;
}

Result<std::shared_ptr<const DecodedBlock>> StoreRecords::Decode(const BlockDirectoryEntry& entry,
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

void StoreRecords::Prefetch(const std::vector<ByteRange>& ranges) const
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
    this->File->Prefetch(joined.Begin, joined.End - joined.Begin);
  }
}

} // namespace isosurface
