// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Verification/StoreVerification.h"

#include "Ground/Base/Buffer.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Ground/Volume/SampleRange.h"
#include "Storage/Index/ExternalIntervalTree.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Record/BlockSegment.h"
#include "Storage/Record/RecordCodec.h"

#include <algorithm>
#include <limits>

namespace isosurface
{
namespace
{

/// Blocks that a thread takes at a time.
constexpr std::uint64_t RunLength = 32;

} // namespace

void StoreVerification::Open()
{
  if (!this->Files.Exists(this->Folder))
  {
    this->OpenFaults.emplace_back(
      StatusCode::NotFound, this->Folder + ": this store of the blocked volume is missing");
    return;
  }
  this->Ranges.resize(this->Variables.GetCount());
  for (std::size_t variable = 0; variable < this->Variables.GetCount(); ++variable)
  {
    this->OpenTree(variable);
  }
  const Status status = this->OpenFiles();
  if (!status.IsOk())
  {
    this->OpenFaults.push_back(status);
    return;
  }
  const auto count = static_cast<std::size_t>(this->Directory->GetCount());
  this->Numbers.assign(count, -1);
  this->Sizes.assign(count, 0);
  this->Checksums.assign(count * this->Segments, 0);
  this->RunFaults.resize(static_cast<std::size_t>(this->GetNumberOfRuns()));
}

Status StoreVerification::OpenFiles()
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    this->Blocks, this->Files.OpenForReading(StoreRecords::GetPath(this->Folder)));
  if (this->Blocks->GetSize() != this->Description.Bytes)
  {
    this->OpenFaults.push_back(
      this->MakeFault("has " + std::to_string(this->Blocks->GetSize()) + " bytes instead of the " +
        std::to_string(this->Description.Bytes) + " that the header states"));
  }
  ISOSURFACE_ASSIGN_OR_RETURN(this->Directory,
    BlockStore::OpenDirectory(
      this->Files, this->Folder, this->Description, this->Segments, this->Place));
  return Status::Ok();
}

std::uint64_t StoreVerification::GetNumberOfRuns() const
{
  return this->Directory ? (this->Directory->GetCount() + RunLength - 1) / RunLength : 0;
}

void StoreVerification::OpenTree(std::size_t variable)
{
  std::vector<KeyRange> ranges;
  const Status status = this->ReadTree(variable, ranges);
  if (status.IsOk())
  {
    this->Ranges[variable] = std::move(ranges);
  }
  else
  {
    this->OpenFaults.push_back(status);
  }
}

Status StoreVerification::ReadTree(std::size_t variable, std::vector<KeyRange>& ranges) const
{
  const std::string path = this->GetTreePath(variable);
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto tree, ExternalIntervalTree::Open(this->Files, path, BlockStore::PageCacheBytes));
  ISOSURFACE_RETURN_IF_ERROR(BlockStore::CheckTree(*tree, this->Description, variable));
  PageStatistics pages;
  ISOSURFACE_RETURN_IF_ERROR(tree->Verify(pages));
  bool isKnown = true;
  ranges.resize(static_cast<std::size_t>(this->Description.Blocks));
  ISOSURFACE_RETURN_IF_ERROR(tree->FindOverlapping(
    0, std::numeric_limits<ValueKey>::max(),
    [&](const KeyInterval& interval)
    {
      isKnown = isKnown && interval.Payload < ranges.size() && ranges[interval.Payload].IsEmpty();
      if (isKnown)
      {
        ranges[interval.Payload] = { interval.Minimum, interval.Maximum };
      }
    },
    pages));
  return isKnown
    ? Status::Ok()
    : Status(StatusCode::Corrupt, path + ": does not have each block of the store once");
}

void StoreVerification::CheckRun(std::uint64_t run)
{
  const std::uint64_t end = std::min((run + 1) * RunLength, this->Directory->GetCount());
  std::vector<Status>& faults = this->RunFaults[static_cast<std::size_t>(run)];
  for (std::uint64_t ordinal = run * RunLength; ordinal < end; ++ordinal)
  {
    const Status status = this->CheckRecord(ordinal, faults);
    if (!status.IsOk())
    {
      // A damaged page of the directory is one fault, not one for each of its blocks.
      if (faults.empty() || faults.back().GetMessage() != status.GetMessage())
      {
        faults.push_back(status);
      }
    }
  }
}

Status StoreVerification::CheckRecord(std::uint64_t ordinal, std::vector<Status>& faults)
{
  QueryStatistics statistics;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto entry,
    this->Directory->Read(
      ordinal, this->Grid.GetNumberOfBlocks(), this->Blocks->GetSize(), statistics));
  const auto index = static_cast<std::size_t>(ordinal);
  this->Numbers[index] = entry.Block;
  if (this->Place == SamplePlace::Source)
  {
    this->Sizes[index] = this->Segments * BlockRecord::SegmentHeaderSize;
    ISOSURFACE_RETURN_IF_ERROR(this->CheckLengths(entry));
    return this->CheckInPlace(entry, ordinal, faults);
  }
  const std::uint64_t size = entry.FindSegment(this->Segments);
  this->Sizes[index] = BlockRecord::AlignUp(size);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckLengths(entry));
  const std::uint64_t padded = std::min(this->Sizes[index], this->Blocks->GetSize() - entry.Offset);
  Buffer<std::uint8_t> record(static_cast<std::size_t>(padded));
  ISOSURFACE_RETURN_IF_ERROR(this->Blocks->Read(entry.Offset, record.GetSize(), record.GetData()));
  this->CheckVariables(entry, ordinal, record.GetData(), faults);
  const bool isPadded = std::all_of(record.GetData() + size, record.GetData() + padded,
    [](std::uint8_t byte) { return byte == 0; });
  return isPadded ? Status::Ok()
                  : this->MakeFault("block " + std::to_string(entry.Block) +
                      ": the bytes after its record are not zero");
}

Status StoreVerification::CheckLengths(const BlockDirectoryEntry& entry) const
{
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  for (std::size_t segment = 0; segment < this->Segments; ++segment)
  {
    const BlockSegment samples(
      this->Grid, entry.Block, static_cast<int>(levels - 1 - segment % levels));
    if (entry.Lengths[segment] >
      samples.GetNumberOfSamples() * GetValueSize(this->Variables[segment / levels].Type))
    {
      return this->MakeFault(
        "block " + std::to_string(entry.Block) + " has an impossible length in the directory");
    }
  }
  return Status::Ok();
}

void StoreVerification::CheckVariables(const BlockDirectoryEntry& entry, std::uint64_t ordinal,
  const std::uint8_t* record, std::vector<Status>& faults)
{
  DecodedBlocks components;
  for (std::size_t component = 0; component < this->Variables.GetNumberOfStored(); ++component)
  {
    components.push_back(this->CheckComponent(entry, ordinal, component, record, faults));
  }
  this->CheckRanges(components, ordinal, faults);
}

Status StoreVerification::CheckInPlace(
  const BlockDirectoryEntry& entry, std::uint64_t ordinal, std::vector<Status>& faults)
{
  constexpr std::size_t headerSize = BlockRecord::SegmentHeaderSize;
  std::vector<std::uint8_t> headers(this->Segments * headerSize);
  ISOSURFACE_RETURN_IF_ERROR(this->Blocks->Read(entry.Offset, headers.size(), headers.data()));
  DecodedBlocks components(this->Segments);
  QueryStatistics statistics;
  for (std::size_t component = 0; component < this->Segments; ++component)
  {
    const std::uint8_t* header = headers.data() + component * headerSize;
    this->Checksums[static_cast<std::size_t>(ordinal) * this->Segments + component] =
      LoadLittleEndian<std::uint64_t>(header);
    if (!this->Source)
    {
      continue;
    }
    auto block = GatherBlock(
      *this->Source, this->Grid, entry, this->Blocks->GetPath(), component, header, statistics);
    if (block.IsOk())
    {
      components[component] = std::move(*block);
    }
    else
    {
      faults.push_back(block.GetStatus());
    }
  }
  this->CheckRanges(components, ordinal, faults);
  return Status::Ok();
}

void StoreVerification::CheckRanges(
  const DecodedBlocks& components, std::uint64_t ordinal, std::vector<Status>& faults) const
{
  for (std::size_t variable = 0; variable < this->Variables.GetCount(); ++variable)
  {
    const std::shared_ptr<const DecodedBlock> block = this->Find(components, variable);
    if (block)
    {
      this->CheckRange(*block, ordinal, variable, faults);
    }
  }
}

std::shared_ptr<const DecodedBlock> StoreVerification::CheckComponent(
  const BlockDirectoryEntry& entry, std::uint64_t ordinal, std::size_t component,
  const std::uint8_t* record, std::vector<Status>& faults)
{
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  const std::size_t first = component * levels;
  std::vector<const std::uint8_t*> segments;
  std::vector<std::uint32_t> lengths;
  bool isIntact = true;
  for (std::size_t index = 0; index < levels; ++index)
  {
    const std::uint8_t* segment = record + entry.FindSegment(first + index);
    const std::uint32_t stored = entry.Lengths[first + index];
    const Status status = CheckSegment(segment, stored,
      { entry.Block, static_cast<std::uint32_t>(component),
        static_cast<std::uint32_t>(levels - 1 - index) });
    if (!status.IsOk())
    {
      faults.push_back(this->MakeFault(status.GetMessage()));
      isIntact = false;
    }
    this->Checksums[static_cast<std::size_t>(ordinal) * this->Segments + first + index] =
      LoadLittleEndian<std::uint64_t>(segment);
    segments.push_back(segment);
    lengths.push_back(stored);
  }
  if (!isIntact)
  {
    return nullptr;
  }
  const auto block = DecodeLevel(this->Grid, entry.Block, static_cast<std::uint32_t>(component), 0,
    this->Variables[component].Type, segments, lengths);
  if (!block.IsOk())
  {
    faults.push_back(this->MakeFault(block.GetStatus().GetMessage()));
    return nullptr;
  }
  return *block;
}

std::shared_ptr<const DecodedBlock> StoreVerification::Find(
  const DecodedBlocks& components, std::size_t variable) const
{
  const Variable& wanted = this->Variables[variable];
  if (!wanted.IsMagnitude())
  {
    return components[variable];
  }
  const auto first =
    components.begin() + static_cast<std::ptrdiff_t>(this->Variables.GetFirst(wanted.Array));
  const DecodedBlocks tuple(first, first + this->Variables.GetComponents(wanted.Array));
  const bool areThere =
    std::all_of(tuple.begin(), tuple.end(), [](const auto& block) { return block != nullptr; });
  return areThere ? MakeMagnitudeBlock(tuple) : nullptr;
}

void StoreVerification::CheckRange(const DecodedBlock& block, std::uint64_t ordinal,
  std::size_t variable, std::vector<Status>& faults) const
{
  if (this->Ranges[variable].empty())
  {
    return;
  }
  const KeyRange& stated = this->Ranges[variable][static_cast<std::size_t>(ordinal)];
  const KeyRange found = FindSampleRange(block.View, block.View.Box).All;
  if (stated.Minimum != found.Minimum || stated.Maximum != found.Maximum)
  {
    faults.emplace_back(StatusCode::Corrupt,
      this->GetTreePath(variable) + ": the interval of block " + std::to_string(block.Block) +
        " is not the range of its values");
  }
}

bool StoreVerification::IsZero(std::uint64_t begin, std::uint64_t end) const
{
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(end - begin));
  return this->Blocks->Read(begin, bytes.size(), bytes.data()).IsOk() &&
    std::all_of(bytes.begin(), bytes.end(), [](std::uint8_t byte) { return byte == 0; });
}

void StoreVerification::Finish(std::vector<std::uint8_t>& seen)
{
  if (!this->Directory)
  {
    return;
  }
  std::uint64_t size = 0;
  std::uint64_t checksum = 0;
  bool isComplete = true;
  for (std::size_t ordinal = 0; ordinal < this->Numbers.size(); ++ordinal)
  {
    isComplete = isComplete && this->Numbers[ordinal] >= 0;
    if (this->Numbers[ordinal] >= 0 && !seen.empty())
    {
      std::uint8_t& count = seen[static_cast<std::size_t>(this->Numbers[ordinal])];
      count = static_cast<std::uint8_t>(std::min(2, count + 1));
    }
    size += this->Sizes[ordinal];
    // Chained as in BlockStoreWriter.
    std::vector<std::uint64_t> chain = { checksum };
    const auto begin =
      this->Checksums.begin() + static_cast<std::ptrdiff_t>(ordinal * this->Segments);
    chain.insert(chain.end(), begin, begin + static_cast<std::ptrdiff_t>(this->Segments));
    checksum = ComputeChecksum(chain.data(), chain.size() * sizeof(chain[0]));
  }
  const std::uint64_t end = size;
  if (this->Place == SamplePlace::Source)
  {
    size = BlockRecord::AlignUp(size);
  }
  if (isComplete && size == this->Blocks->GetSize() && !this->IsZero(end, size))
  {
    this->OpenFaults.push_back(this->MakeFault("the bytes after its records are not zero"));
  }
  if (isComplete && size != this->Blocks->GetSize())
  {
    this->OpenFaults.push_back(this->MakeFault("its records take " + std::to_string(size) +
      " of its " + std::to_string(this->Blocks->GetSize()) + " bytes"));
  }
  if (isComplete && checksum != this->Description.Checksum)
  {
    this->OpenFaults.push_back(
      this->MakeFault("is not the store that the header describes: its checksum is " +
        FormatChecksum(checksum) + ", not " + FormatChecksum(this->Description.Checksum)));
  }
}

std::vector<Status> StoreVerification::TakeFaults()
{
  std::vector<Status> faults = std::move(this->OpenFaults);
  for (std::vector<Status>& of : this->RunFaults)
  {
    for (Status& fault : of)
    {
      // Runs may share a damaged page of the directory.
      if (faults.empty() || faults.back().GetMessage() != fault.GetMessage())
      {
        faults.push_back(std::move(fault));
      }
    }
  }
  return faults;
}

} // namespace isosurface
