// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/BlockStoreWriter.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Storage/Index/ExternalIntervalTreeBuilder.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Store/BlockStore.h"

#include <algorithm>
#include <iterator>

namespace isosurface
{

BlockStoreWriter::BlockStoreWriter(FileSystem& files, std::string folder, std::size_t segments,
  std::unique_ptr<WritableFile> blocksFile, std::size_t blocks, SamplePlace place)
  : Files(files)
  , Folder(std::move(folder))
  , Segments(segments)
  , Place(place)
  , Blocks(std::move(blocksFile))
{
  this->Entries.reserve(blocks);
}

Result<std::unique_ptr<BlockStoreWriter>> BlockStoreWriter::Create(FileSystem& files,
  const std::string& folder, std::size_t segments, std::size_t blocks, SamplePlace place)
{
  ISOSURFACE_RETURN_IF_ERROR(files.MakeDirectories(folder));
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto blocksFile, files.CreateForWriting(StoreRecords::GetPath(folder)));
  return std::unique_ptr<BlockStoreWriter>(
    new BlockStoreWriter(files, folder, segments, std::move(blocksFile), blocks, place));
}

Result<std::unique_ptr<BlockStoreWriter>> BlockStoreWriter::Open(FileSystem& files,
  const std::string& folder, std::size_t segments, std::size_t blocks, SamplePlace place,
  std::vector<BlockDirectoryEntry> entries, const StoreCheckpoint& checkpoint)
{
  std::vector<std::uint64_t> ends;
  for (std::size_t next = 1; next <= entries.size(); ++next)
  {
    ends.push_back(next < entries.size() ? entries[next].Offset : checkpoint.BlocksBytes);
    if (ends.back() < entries[next - 1].Offset)
    {
      return Status(StatusCode::Corrupt, folder + ": its journal is damaged");
    }
  }
  const std::string path = StoreRecords::GetPath(folder);
  const AppendedSum sum(checkpoint.BlocksSum);
  ISOSURFACE_RETURN_IF_ERROR(sum.Check(files, path, ends));
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto blocksFile, files.OpenForAppending(path, checkpoint.BlocksBytes));
  std::unique_ptr<BlockStoreWriter> writer(
    new BlockStoreWriter(files, folder, segments, std::move(blocksFile), blocks, place));
  writer->Entries.insert(writer->Entries.end(), std::make_move_iterator(entries.begin()),
    std::make_move_iterator(entries.end()));
  writer->Checksum = checkpoint.BlocksChecksum;
  writer->Sum = sum;
  return writer;
}

Status BlockStoreWriter::Append(const PendingBlock& block)
{
  this->Entries.push_back({ block.Block, this->Blocks->GetSize(), block.Layout.Lengths });
  // The store's checksum chains those of the segments, which are their first bytes.
  std::vector<std::uint64_t> checksums = { this->Checksum };
  for (const std::uint64_t offset : block.Layout.Offsets)
  {
    checksums.push_back(LoadLittleEndian<std::uint64_t>(block.Record.GetData() + offset));
  }
  this->Checksum = ComputeChecksum(checksums.data(), checksums.size() * sizeof(checksums[0]));
  return this->Place == SamplePlace::Source
    ? this->AppendHeaders(block)
    : this->AppendBytes(
        block.Record.GetData(), static_cast<std::size_t>(BlockRecord::AlignUp(block.Layout.Size)));
}

Status BlockStoreWriter::AppendBytes(const std::uint8_t* bytes, std::size_t size)
{
  this->Sum.Add(bytes, size);
  return this->Blocks->Append(bytes, size);
}

Status BlockStoreWriter::AppendHeaders(const PendingBlock& block)
{
  std::vector<std::uint8_t> headers;
  for (const std::uint64_t offset : block.Layout.Offsets)
  {
    const std::uint8_t* header = block.Record.GetData() + offset;
    headers.insert(headers.end(), header, header + BlockRecord::SegmentHeaderSize);
  }
  return this->AppendBytes(headers.data(), headers.size());
}

Result<StoreDescription> BlockStoreWriter::Finish(const ArrayVariables& variables,
  const std::vector<std::vector<KeyRange>>& ranges, std::size_t memoryBytes)
{
  if (this->Place == SamplePlace::Source)
  {
    const std::uint64_t size = this->Blocks->GetSize();
    const std::vector<std::uint8_t> zeros(
      static_cast<std::size_t>(BlockRecord::AlignUp(size) - size), 0);
    ISOSURFACE_RETURN_IF_ERROR(this->Blocks->Append(zeros.data(), zeros.size()));
  }
  StoreDescription description = { this->Entries.size(), this->Blocks->GetSize(), this->Checksum,
    std::vector<std::uint64_t>(1 + ranges.size()) };
  ISOSURFACE_RETURN_IF_ERROR(this->Blocks->SyncAndClose());
  for (std::size_t variable = 0; variable < ranges.size(); ++variable)
  {
    const std::string path = BlockStore::GetTreePath(this->Folder, variables, variable);
    ISOSURFACE_ASSIGN_OR_RETURN(const auto seal,
      this->WriteTree(
        path, BlockStore::GetTreeIdentity(description, variable), ranges[variable], memoryBytes));
    description.Seals[1 + variable] = seal;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto seal,
    BlockDirectory::Write(this->Files, BlockStore::GetDirectoryPath(this->Folder), this->Segments,
      this->Checksum, this->Entries));
  description.Seals.front() = seal;
  ISOSURFACE_RETURN_IF_ERROR(this->Files.SyncDirectory(this->Folder));
  return description;
}

Result<std::uint64_t> BlockStoreWriter::WriteTree(const std::string& path, std::uint64_t identity,
  const std::vector<KeyRange>& ranges, std::size_t memoryBytes) const
{
  ExternalIntervalTreeBuilder builder(
    this->Files, path, std::max(memoryBytes, ExternalIntervalTreeBuilder::MinimumMemoryLimit));
  builder.SetIdentity(identity);
  for (std::size_t ordinal = 0; ordinal < this->Entries.size(); ++ordinal)
  {
    const KeyRange& range = ranges[static_cast<std::size_t>(this->Entries[ordinal].Block)];
    ISOSURFACE_RETURN_IF_ERROR(
      builder.Add({ range.Minimum, range.Maximum, static_cast<std::uint32_t>(ordinal) }));
  }
  ISOSURFACE_RETURN_IF_ERROR(builder.Finish());
  return builder.GetSeal();
}

} // namespace isosurface
