// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockDirectory.h"

#include "Ground/Base/Coding.h"
#include "Storage/Record/BlockRecord.h"

#include <algorithm>

namespace isosurface
{
namespace
{

constexpr PagedFile::Kind DirectoryKind = { 'B', 'L', 'O', 'C', 'K', 'D', 'I', 'R' };

std::size_t GetEntrySize(std::size_t segments)
{
  return 16 + 4 * segments;
}

std::uint32_t ChoosePageSize(std::size_t segments)
{
  std::uint32_t size = PagedFile::DefaultPageSize;
  while (size < 16384 && size - PagedFile::ChecksumSize < GetEntrySize(segments))
  {
    size *= 2;
  }
  return size;
}

} // namespace

std::uint64_t BlockDirectoryEntry::FindSegment(std::size_t segment) const
{
  std::uint64_t offset = 0;
  for (std::size_t before = 0; before < segment; ++before)
  {
    offset += BlockRecord::SegmentHeaderSize + this->Lengths[before];
  }
  return offset;
}

Result<std::uint64_t> BlockDirectory::Write(FileSystem& fileSystem, const std::string& path,
  std::size_t segments, std::uint64_t identity, const std::vector<BlockDirectoryEntry>& entries)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto file, PagedFileWriter::Create(fileSystem, path, ChoosePageSize(segments), DirectoryKind));
  PagedFileWriter& writer = *file;
  const std::size_t entrySize = GetEntrySize(segments);
  const std::size_t perPage = writer.GetPayloadSize() / entrySize;
  std::vector<std::uint8_t> payload(writer.GetPayloadSize());
  for (std::size_t first = 0; first < entries.size(); first += perPage)
  {
    std::fill(payload.begin(), payload.end(), std::uint8_t{ 0 });
    const std::size_t count = std::min(perPage, entries.size() - first);
    for (std::size_t index = 0; index < count; ++index)
    {
      const BlockDirectoryEntry& entry = entries[first + index];
      std::uint8_t* to = payload.data() + index * entrySize;
      StoreLittleEndian(to, static_cast<std::uint64_t>(entry.Block));
      StoreLittleEndian(to + 8, entry.Offset);
      for (std::size_t segment = 0; segment < segments; ++segment)
      {
        StoreLittleEndian(to + 16 + 4 * segment, entry.Lengths[segment]);
      }
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto page, writer.AllocatePage());
    ISOSURFACE_RETURN_IF_ERROR(writer.WritePage(page, payload.data()));
  }
  PagedFile::ClientArea area = {};
  StoreLittleEndian(area.data(), static_cast<std::uint64_t>(entries.size()));
  StoreLittleEndian(area.data() + 8, static_cast<std::uint32_t>(segments));
  StoreLittleEndian(area.data() + 16, identity);
  ISOSURFACE_RETURN_IF_ERROR(writer.Finish(area));
  return writer.GetSeal();
}

BlockDirectory::BlockDirectory(std::unique_ptr<PagedFileReader> file, std::uint64_t count,
  std::size_t segments, SamplePlace place)
  : File(std::move(file))
  , Count(count)
  , Segments(segments)
  , Place(place)
{
}

Result<std::unique_ptr<BlockDirectory>> BlockDirectory::Open(FileSystem& fileSystem,
  const std::string& path, std::uint64_t entries, std::size_t segments, std::uint64_t identity,
  std::size_t cacheBytes, SamplePlace place)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, fileSystem.OpenForReading(path));
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto reader, PagedFileReader::Open(std::move(file), DirectoryKind, cacheBytes));
  const PagedFileReader& pages = *reader;
  const std::uint8_t* area = pages.GetClientArea().data();
  if (LoadLittleEndian<std::uint64_t>(area) != entries ||
    LoadLittleEndian<std::uint32_t>(area + 8) != segments)
  {
    return pages.MakeCorrupt(0, "its numbers of blocks and segments are not those of the header");
  }
  if (LoadLittleEndian<std::uint64_t>(area + 16) != identity)
  {
    return pages.MakeCorrupt(0, "it is the directory of another store or time step");
  }
  const std::size_t perPage = pages.GetPayloadSize() / GetEntrySize(segments);
  if (perPage == 0 ||
    pages.GetPageCount() - 1 != entries / perPage + (entries % perPage != 0 ? 1 : 0))
  {
    return pages.MakeCorrupt(0, "its number of pages does not fit its number of blocks");
  }
  return std::unique_ptr<BlockDirectory>(
    new BlockDirectory(std::move(reader), entries, segments, place));
}

Result<BlockDirectoryEntry> BlockDirectory::Read(std::uint64_t ordinal, std::int64_t blocks,
  std::uint64_t fileSize, QueryStatistics& statistics) const
{
  if (ordinal >= this->Count)
  {
    return Status(StatusCode::Corrupt,
      this->GetPath() + ": there is no block number " + std::to_string(ordinal));
  }
  const std::size_t entrySize = GetEntrySize(this->Segments);
  const std::uint64_t perPage = this->File->GetPayloadSize() / entrySize;
  const std::uint64_t number = 1 + ordinal / perPage;
  PageStatistics pages;
  const auto page = this->File->ReadPage(number, pages);
  statistics.DirectoryPagesRead += pages.PageReads;
  ISOSURFACE_RETURN_IF_ERROR(page.GetStatus());
  const std::uint8_t* from = (*page)->data() + (ordinal % perPage) * entrySize;
  BlockDirectoryEntry entry;
  const auto block = LoadLittleEndian<std::uint64_t>(from);
  entry.Offset = LoadLittleEndian<std::uint64_t>(from + 8);
  entry.Lengths.resize(this->Segments);
  for (std::size_t segment = 0; segment < this->Segments; ++segment)
  {
    entry.Lengths[segment] = LoadLittleEndian<std::uint32_t>(from + 16 + 4 * segment);
  }
  const bool isWhole = this->Place == SamplePlace::Store;
  const std::uint64_t alignment = isWhole ? BlockRecord::Alignment : BlockRecord::SegmentHeaderSize;
  const std::uint64_t size =
    isWhole ? entry.FindSegment(this->Segments) : this->Segments * BlockRecord::SegmentHeaderSize;
  if (block >= static_cast<std::uint64_t>(blocks) || entry.Offset % alignment != 0 ||
    entry.Offset > fileSize || size > fileSize - entry.Offset)
  {
    return this->File->MakeCorrupt(
      number, "the entry of block number " + std::to_string(ordinal) + " is impossible");
  }
  entry.Block = static_cast<std::int64_t>(block);
  return entry;
}

} // namespace isosurface
