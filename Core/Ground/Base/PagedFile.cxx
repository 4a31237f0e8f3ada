// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/PagedFile.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::array<char, 8> Magic = { 'I', 'S', 'O', 'P', 'A', 'G', 'E', 'D' };

// Offsets in page 0; see the drawing in PagedFile.h.
constexpr std::size_t VersionOffset = 8;
constexpr std::size_t PageSizeOffset = 12;
constexpr std::size_t PageCountOffset = 16;
constexpr std::size_t KindOffset = 24;
constexpr std::size_t ClientAreaOffset = 32;
constexpr std::size_t FixedHeaderSize = ClientAreaOffset + PagedFile::ClientAreaSize;
constexpr std::size_t GroupSizeOffset = FixedHeaderSize;
static_assert(GroupSizeOffset + sizeof(std::uint64_t) == PagedFile::SumsOffset);

// The memory of a cached page besides its bytes: nodes of list and map, vector, shared pointer,
// malloc.
constexpr std::size_t CacheOverhead = 256;

} // namespace

Result<std::unique_ptr<PagedFileWriter>> PagedFileWriter::Create(FileSystem& fileSystem,
  const std::string& path, std::uint32_t pageSize, const PagedFile::Kind& kind)
{
  if (!PagedFile::IsPageSize(pageSize))
  {
    return Status(StatusCode::InvalidArgument,
      path + ": a page of " + std::to_string(pageSize) + " bytes is not 4096, 8192 or 16384 bytes");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, fileSystem.CreateForWriting(path));
  return std::unique_ptr<PagedFileWriter>(new PagedFileWriter(std::move(file), pageSize, kind));
}

PagedFileWriter::PagedFileWriter(
  std::unique_ptr<WritableFile> file, std::uint32_t pageSize, const PagedFile::Kind& kind)
  : File(std::move(file))
  , PageSize(pageSize)
  , Kind(kind)
  , Scratch(pageSize)
{
  this->Pending.reserve(WriteBehindSize);
  this->Pending.resize(pageSize); // page 0, zeros until Finish()
  this->PageCount = 1;
}

Result<std::uint32_t> PagedFileWriter::AllocatePage()
{
  if (this->PageCount > std::numeric_limits<std::uint32_t>::max())
  {
    return Status(StatusCode::Unsupported, this->File->GetPath() + ": more than 2^32 pages");
  }
  if (this->Pending.size() + this->PageSize > WriteBehindSize)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Flush());
  }
  this->Pending.resize(this->Pending.size() + this->PageSize);
  return static_cast<std::uint32_t>(this->PageCount++);
}

Status PagedFileWriter::WritePage(std::uint32_t page, const std::uint8_t* payload)
{
  assert(page < this->PageCount);
  const bool pending = page >= this->FlushedPages;
  std::uint8_t* bytes = pending
    ? this->Pending.data() + static_cast<std::size_t>(page - this->FlushedPages) * this->PageSize
    : this->Scratch.data();
  std::copy(payload, payload + this->GetPayloadSize(), bytes);
  const std::uint64_t checksum = this->Seal(page, bytes);
  if (page == 0)
  {
    this->SealOfFile = checksum;
  }
  else
  {
    this->AddToSums(page, checksum);
  }
  if (pending)
  {
    return Status::Ok();
  }
  return this->File->WriteAt(std::uint64_t(page) * this->PageSize, bytes, this->PageSize);
}

Status PagedFileWriter::Finish(const PagedFile::ClientArea& clientArea)
{
  // Page 0 is written last: without it the file is not valid.
  ISOSURFACE_RETURN_IF_ERROR(this->Flush());
  std::vector<std::uint8_t> header(this->GetPayloadSize(), 0);
  std::copy(Magic.begin(), Magic.end(), header.begin());
  StoreLittleEndian(&header[VersionOffset], PagedFile::FormatVersion);
  StoreLittleEndian(&header[PageSizeOffset], this->PageSize);
  StoreLittleEndian(&header[PageCountOffset], this->PageCount);
  std::copy(this->Kind.begin(), this->Kind.end(), header.begin() + KindOffset);
  std::copy(clientArea.begin(), clientArea.end(), header.begin() + ClientAreaOffset);
  StoreLittleEndian(&header[GroupSizeOffset], this->GroupSize);
  for (std::size_t group = 0; group < this->Sums.size(); ++group)
  {
    StoreLittleEndian(
      &header[PagedFile::SumsOffset + group * sizeof(std::uint64_t)], this->Sums[group]);
  }
  ISOSURFACE_RETURN_IF_ERROR(this->WritePage(0, header.data()));
  return this->File->SyncAndClose();
}

Status PagedFileWriter::Flush()
{
  ISOSURFACE_RETURN_IF_ERROR(this->File->Append(this->Pending.data(), this->Pending.size()));
  this->Pending.clear();
  this->FlushedPages = this->PageCount;
  return Status::Ok();
}

std::uint64_t PagedFileWriter::Seal(std::uint64_t page, std::uint8_t* bytes) const
{
  const std::size_t size = this->GetPayloadSize();
  const std::uint64_t checksum = ComputeChecksum(bytes, size, page);
  StoreLittleEndian(bytes + size, checksum);
  return checksum;
}

void PagedFileWriter::AddToSums(std::uint64_t page, std::uint64_t checksum)
{
  while ((page - 1) / this->GroupSize >= PagedFile::GetSumLimit(this->PageSize))
  {
    // Two groups become one: their sums can be added, whichever pages were written so far.
    this->GroupSize *= 2;
    for (std::size_t group = 0; group < this->Sums.size(); ++group)
    {
      const std::uint64_t sum = this->Sums[group];
      this->Sums[group] = 0;
      this->Sums[group / 2] += sum;
    }
    this->Sums.resize((this->Sums.size() + 1) / 2);
  }
  const auto group = static_cast<std::size_t>((page - 1) / this->GroupSize);
  this->Sums.resize(std::max(this->Sums.size(), group + 1));
  this->Sums[group] += checksum;
}

Result<std::unique_ptr<PagedFileReader>> PagedFileReader::Open(
  std::unique_ptr<RandomAccessFile> file, const PagedFile::Kind& kind, std::size_t cacheBytes)
{
  std::unique_ptr<PagedFileReader> reader(new PagedFileReader(std::move(file)));
  ISOSURFACE_RETURN_IF_ERROR(reader->ReadHeader(kind));
  reader->CachePages = cacheBytes / (reader->PageSize + CacheOverhead);
  return reader;
}

PagedFileReader::PagedFileReader(std::unique_ptr<RandomAccessFile> file)
  : File(std::move(file))
{
}

Status PagedFileReader::ReadHeader(const PagedFile::Kind& kind)
{
  if (this->File->GetSize() < FixedHeaderSize)
  {
    return this->MakeCorrupt(0, "truncated: the file is too short for its header");
  }
  std::array<std::uint8_t, FixedHeaderSize> header;
  ISOSURFACE_RETURN_IF_ERROR(this->File->Read(0, header.size(), header.data()));
  if (!std::equal(Magic.begin(), Magic.end(), header.begin()))
  {
    return this->MakeCorrupt(0, "this is not a paged file (wrong magic)");
  }
  // First the version: the rest of a newer version may have another layout.
  const auto version = LoadLittleEndian<std::uint32_t>(&header[VersionOffset]);
  if (version > PagedFile::FormatVersion)
  {
    return Status(StatusCode::Unsupported,
      this->GetPath() + ": written by a newer version (paged file format " +
        std::to_string(version) + ", this program reads up to " +
        std::to_string(PagedFile::FormatVersion) + ")");
  }
  const auto pageSize = LoadLittleEndian<std::uint32_t>(&header[PageSizeOffset]);
  if (version == 0 || !PagedFile::IsPageSize(pageSize))
  {
    return this->MakeCorrupt(0, "impossible version or page size");
  }
  this->PageSize = pageSize;
  const auto pageCount = LoadLittleEndian<std::uint64_t>(&header[PageCountOffset]);
  if (this->File->GetSize() % pageSize != 0 || this->File->GetSize() / pageSize != pageCount)
  {
    return this->MakeCorrupt(0,
      "truncated or too long: " + std::to_string(this->File->GetSize()) + " bytes are not " +
        std::to_string(pageCount) + " pages of " + std::to_string(pageSize) + " bytes");
  }
  this->PageCount = pageCount;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto page, this->ReadFromDisk(0));
  if (!std::equal(kind.begin(), kind.end(), page->begin() + KindOffset))
  {
    return this->MakeCorrupt(
      0, "the file is not of the kind " + std::string(kind.begin(), kind.end()));
  }
  std::copy_n(
    page->begin() + ClientAreaOffset, PagedFile::ClientAreaSize, this->ClientArea.begin());
  return this->TakeSums(*page);
}

Status PagedFileReader::TakeSums(const std::vector<std::uint8_t>& first)
{
  this->Seal = LoadLittleEndian<std::uint64_t>(first.data() + this->GetPayloadSize());
  const auto size = LoadLittleEndian<std::uint64_t>(first.data() + GroupSizeOffset);
  const std::uint64_t pages = this->PageCount - 1;
  const std::size_t limit = PagedFile::GetSumLimit(this->PageSize);
  const auto countGroups = [&](std::uint64_t ofSize)
  { return pages / ofSize + (pages % ofSize != 0 ? 1 : 0); };
  if (size == 0)
  {
    return Status::Ok();
  }
  if ((size & (size - 1)) != 0 || countGroups(size) > limit ||
    (size > 1 && countGroups(size / 2) <= limit))
  {
    return this->MakeCorrupt(0, "its pages cannot be in groups of " + std::to_string(size));
  }
  this->GroupSize = size;
  this->Sums.resize(static_cast<std::size_t>(countGroups(size)));
  for (std::size_t group = 0; group < this->Sums.size(); ++group)
  {
    this->Sums[group] = LoadLittleEndian<std::uint64_t>(
      first.data() + PagedFile::SumsOffset + group * sizeof(std::uint64_t));
  }
  return Status::Ok();
}

Status PagedFileReader::CheckSeal(std::uint64_t seal) const
{
  return this->GroupSize > 0 && this->Seal == seal
    ? Status::Ok()
    : this->MakeCorrupt(0,
        "this is not the file that was written: its seal is " + FormatChecksum(this->Seal) +
          ", not " + FormatChecksum(seal) + " as the volume's header says");
}

Result<PagedFileReader::Page> PagedFileReader::ReadPage(
  std::uint64_t page, PageStatistics& statistics) const
{
  if (page >= this->PageCount)
  {
    return this->MakeCorrupt(page, "the file has no such page");
  }
  if (Page cached = this->FindInCache(page))
  {
    ++statistics.CacheHits;
    return cached;
  }
  auto read = this->ReadFromDisk(page);
  ++statistics.PageReads;
  if (read.IsOk())
  {
    this->PutIntoCache(page, *read);
  }
  return read;
}

Result<PagedFileReader::Page> PagedFileReader::ReadFromDisk(std::uint64_t page) const
{
  auto bytes = std::make_shared<std::vector<std::uint8_t>>(this->PageSize);
  ISOSURFACE_RETURN_IF_ERROR(
    this->File->Read(page * this->PageSize, this->PageSize, bytes->data()));
  const std::size_t size = this->GetPayloadSize();
  const auto checksum = LoadLittleEndian<std::uint64_t>(bytes->data() + size);
  if (checksum != ComputeChecksum(bytes->data(), size, page))
  {
    return this->MakeCorrupt(page, "wrong checksum");
  }
  ISOSURFACE_RETURN_IF_ERROR(this->CheckGroup(page, checksum));
  return Page(std::move(bytes));
}

Status PagedFileReader::CheckGroup(std::uint64_t page, std::uint64_t checksum) const
{
  if (page == 0 || this->GroupSize == 0)
  {
    return Status::Ok();
  }
  const std::uint64_t group = (page - 1) / this->GroupSize;
  const std::uint64_t first = 1 + group * this->GroupSize;
  std::vector<std::uint64_t> checksums;
  {
    const std::lock_guard<std::mutex> lock(this->CacheMutex);
    const auto known = this->KnownGroups.find(group);
    if (known != this->KnownGroups.end())
    {
      return known->second[static_cast<std::size_t>(page - first)] == checksum
        ? Status::Ok()
        : this->MakeCorrupt(page, "was changed since the file was opened");
    }
  }
  std::uint64_t sum = 0;
  for (std::uint64_t other = first; other < std::min(first + this->GroupSize, this->PageCount);
       ++other)
  {
    std::array<std::uint8_t, PagedFile::ChecksumSize> bytes{};
    StoreLittleEndian(bytes.data(), checksum);
    if (other != page)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->File->Read(
        other * this->PageSize + this->GetPayloadSize(), bytes.size(), bytes.data()));
    }
    checksums.push_back(LoadLittleEndian<std::uint64_t>(bytes.data()));
    sum += checksums.back();
  }
  if (sum != this->Sums[static_cast<std::size_t>(group)])
  {
    return this->MakeCorrupt(page,
      this->GroupSize == 1
        ? "this is not the page that was written: its checksum is not the one that page 0 has"
        : "the pages " + std::to_string(first) + " to " +
          std::to_string(first + checksums.size() - 1) +
          " are not those that were written: page 0 has another sum of their checksums");
  }
  if (this->GroupSize > 1)
  {
    const std::lock_guard<std::mutex> lock(this->CacheMutex);
    this->KnownGroups.emplace(group, std::move(checksums));
  }
  return Status::Ok();
}

PagedFileReader::Page PagedFileReader::FindInCache(std::uint64_t page) const
{
  if (this->CachePages == 0)
  {
    return nullptr;
  }
  const std::lock_guard<std::mutex> lock(this->CacheMutex);
  const auto found = this->CacheIndex.find(page);
  if (found == this->CacheIndex.end())
  {
    return nullptr;
  }
  this->Cache.splice(this->Cache.begin(), this->Cache, found->second);
  return found->second->Bytes;
}

void PagedFileReader::PutIntoCache(std::uint64_t page, const Page& bytes) const
{
  if (this->CachePages == 0)
  {
    return;
  }
  const std::lock_guard<std::mutex> lock(this->CacheMutex);
  if (this->CacheIndex.count(page) != 0)
  {
    return; // another thread read it meanwhile
  }
  if (this->Cache.size() == this->CachePages)
  {
    this->CacheIndex.erase(this->Cache.back().Number);
    this->Cache.pop_back();
  }
  this->Cache.push_front({ page, bytes });
  this->CacheIndex.emplace(page, this->Cache.begin());
}

Status PagedFileReader::MakeCorrupt(std::uint64_t page, const std::string& reason) const
{
  return Status(
    StatusCode::Corrupt, this->GetPath() + ": page " + std::to_string(page) + ": " + reason);
}

} // namespace isosurface
