// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockStoreWriter.h"

#include "Base/ByteOrder.h"
#include "Base/Checksum.h"
#include "Index/ExternalIntervalTreeBuilder.h"
#include "Store/BlockStore.h"

#include <algorithm>

namespace isosurface
{

BlockStoreWriter::BlockStoreWriter(FileSystem& files, std::string folder, std::size_t segments,
  std::unique_ptr<WritableFile> blocks, std::vector<StoreCursor> cursors)
  : Files(files)
  , Folder(std::move(folder))
  , Segments(segments)
  , Blocks(std::move(blocks))
  , Entries(static_cast<std::size_t>(cursors.back().Ordinal))
  , Cursors(std::move(cursors))
  , Checksums(Entries.size() * segments)
{
}

Result<std::unique_ptr<BlockStoreWriter>> BlockStoreWriter::Create(FileSystem& files,
  const std::string& folder, std::size_t segments, std::vector<StoreCursor> cursors)
{
  ISOSURFACE_RETURN_IF_ERROR(files.MakeDirectories(folder));
  auto blocks = files.CreateForWriting(BlockStore::GetBlocksPath(folder));
  if (!blocks.IsOk())
  {
    return blocks.GetStatus();
  }
  return std::unique_ptr<BlockStoreWriter>(
    new BlockStoreWriter(files, folder, segments, std::move(*blocks), std::move(cursors)));
}

Status BlockStoreWriter::Write(const PendingBlock& block, std::size_t lane)
{
  StoreCursor& cursor = this->Cursors[lane];
  const auto ordinal = static_cast<std::size_t>(cursor.Ordinal);
  this->Entries[ordinal] = { block.Block, cursor.Offset, block.Layout.Lengths };
  // A segment's own checksum stands at its begin.
  std::uint64_t* checksum = this->Checksums.data() + ordinal * this->Segments;
  for (const std::uint64_t offset : block.Layout.Offsets)
  {
    *checksum++ = LoadLittleEndian<std::uint64_t>(block.Record.GetData() + offset);
  }
  const std::uint64_t offset = cursor.Offset;
  cursor = { cursor.Ordinal + 1, offset + block.Record.GetSize() };
  return this->Blocks->WriteAt(offset, block.Record.GetData(), block.Record.GetSize());
}

Result<StoreDescription> BlockStoreWriter::Finish(
  const std::vector<std::vector<KeyRange>>& ranges, std::size_t memoryBytes)
{
  const StoreDescription description = { this->Entries.size(), this->Cursors.back().Offset,
    this->ChainChecksums() };
  ISOSURFACE_RETURN_IF_ERROR(this->Blocks->SyncAndClose());
  for (std::size_t array = 0; array < ranges.size(); ++array)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->WriteTree(array, ranges[array], memoryBytes));
  }
  ISOSURFACE_RETURN_IF_ERROR(BlockDirectory::Write(
    this->Files, BlockStore::GetDirectoryPath(this->Folder), this->Segments, this->Entries));
  ISOSURFACE_RETURN_IF_ERROR(this->Files.SyncDirectory(this->Folder));
  return description;
}

/// The store's checksum chains those of the segments, block by block.
std::uint64_t BlockStoreWriter::ChainChecksums() const
{
  std::vector<std::uint64_t> link(1 + this->Segments, 0);
  for (std::size_t first = 0; first < this->Checksums.size(); first += this->Segments)
  {
    std::copy_n(this->Checksums.data() + first, this->Segments, link.begin() + 1);
    link[0] = ComputeChecksum(link.data(), link.size() * sizeof(link[0]));
  }
  return link[0];
}

Status BlockStoreWriter::WriteTree(
  std::size_t array, const std::vector<KeyRange>& ranges, std::size_t memoryBytes) const
{
  ExternalIntervalTreeBuilder builder(this->Files, BlockStore::GetTreePath(this->Folder, array),
    std::max(memoryBytes, ExternalIntervalTreeBuilder::LeastMemoryLimit));
  for (std::size_t ordinal = 0; ordinal < this->Entries.size(); ++ordinal)
  {
    const KeyRange& range = ranges[static_cast<std::size_t>(this->Entries[ordinal].Block)];
    ISOSURFACE_RETURN_IF_ERROR(
      builder.Add({ range.Minimum, range.Maximum, static_cast<std::uint32_t>(ordinal) }));
  }
  return builder.Finish();
}

} // namespace isosurface
