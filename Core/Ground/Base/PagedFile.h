// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PagedFile_h
#define isosurface_PagedFile_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

namespace isosurface
{

/// The pages that one or several queries read.
struct PageStatistics
{
  std::uint64_t PageReads = 0; ///< pages read from disk
  std::uint64_t CacheHits = 0; ///< pages found in the reader's cache
};

/**
 * A file of pages of one size (4096, 8192 or 16384 bytes). Each page has its own checksum, so it
 * can be read and checked alone. Page 0 says what the file is; pages 1 .. n - 1 belong to the user
 * of the file. All numbers are little-endian.
 *
 *     page 0                                        page p
 *     +------+--------------------------------+     +------+--------------------------------+
 *     |    0 | magic "ISOPAGED"               |     |    0 | payload, PageSize - 8 bytes    |
 *     |    8 | format version     (uint32)    |     |  ... |                                |
 *     |   12 | page size in bytes (uint32)    |     | PageSize - 8 : checksum (uint64)      |
 *     |   16 | number of pages    (uint64)    |     +------+--------------------------------+
 *     |   24 | kind, 8 characters             |
 *     |   32 | client area, 256 bytes         |     checksum = XXH3-64 of the payload, with the
 *     |  288 | pages a group G    (uint64)    |     page's number as seed: a page in a wrong place
 *     |  296 | sums of groups     (uint64)    |     does not match its checksum
 *     |  ... | zeros                          |
 *     | PageSize - 8 : checksum (uint64)      |
 *     +------+--------------------------------+
 *
 * The pages from 1 on are in groups of G, the last one may be smaller. The sum of a group is that of
 * its pages' checksums, modulo 2^64. G is the minimum power of two with which all sums fit. So the
 * checksum of page 0, the file's seal, stands for every byte of the file: a page that is whole, but
 * not the one that was written, does not match its sum. Files without sums have G = 0.
 */
struct PagedFile
{
  static constexpr std::uint32_t FormatVersion = 1;
  static constexpr std::uint32_t DefaultPageSize = 4096;
  static constexpr std::size_t ChecksumSize = 8;
  static constexpr std::size_t ClientAreaSize = 256;
  static constexpr std::size_t SumsOffset = 296;

  /// Eight characters that name the content of the pages.
  using Kind = std::array<char, 8>;
  /// Bytes of page 0 that belong to the user of the file.
  using ClientArea = std::array<std::uint8_t, ClientAreaSize>;

  static bool IsPageSize(std::uint64_t size)
  {
    return size == 4096 || size == 8192 || size == 16384;
  }

  /// The number of sums that fit page 0: 474 in pages of 4096 bytes.
  static std::size_t GetSumLimit(std::size_t pageSize)
  {
    return (pageSize - SumsOffset - ChecksumSize) / sizeof(std::uint64_t);
  }
};

/**
 * Writes a paged file. Pages are allocated in order and may be written in any order, each once.
 * Finish() writes page 0 last: a file without it is not valid. Memory: WriteBehindSize bytes, so that
 * successive pages reach the disk in one write, and two pages.
 */
class PagedFileWriter
{
public:
  static constexpr std::size_t WriteBehindSize = 64 * 1024;

  /// Creates the file. Errors: InvalidArgument for another page size, those of CreateForWriting.
  static Result<std::unique_ptr<PagedFileWriter>> Create(FileSystem& fileSystem,
    const std::string& path, std::uint32_t pageSize, const PagedFile::Kind& kind);

  std::size_t GetPayloadSize() const { return this->PageSize - PagedFile::ChecksumSize; }
  std::uint64_t GetPageCount() const { return this->PageCount; }

  /// Adds a page at the end; returns its number. The page must be written before Finish().
  Result<std::uint32_t> AllocatePage();
  /// Writes GetPayloadSize() bytes as the payload of an allocated page, and its checksum.
  Status WritePage(std::uint32_t page, const std::uint8_t* payload);
  /// Writes page 0, flushes the file to stable storage and closes it.
  Status Finish(const PagedFile::ClientArea& clientArea);

  /// The checksum of page 0, after Finish().
  std::uint64_t GetSeal() const { return this->SealOfFile; }

private:
  PagedFileWriter(
    std::unique_ptr<WritableFile> file, std::uint32_t pageSize, const PagedFile::Kind& kind);
  Status Flush();
  /// Puts the checksum of a page behind its payload; returns it.
  std::uint64_t Seal(std::uint64_t page, std::uint8_t* bytes) const;
  void AddToSums(std::uint64_t page, std::uint64_t checksum);

  std::unique_ptr<WritableFile> File;
  std::uint32_t PageSize;
  PagedFile::Kind Kind;
  std::uint64_t PageCount = 0;
  std::uint64_t FlushedPages = 0;
  std::vector<std::uint8_t> Pending; // pages FlushedPages .. PageCount - 1
  std::vector<std::uint8_t> Scratch; // one page
  std::uint64_t GroupSize = 1;
  std::vector<std::uint64_t> Sums; // by group
  std::uint64_t SealOfFile = 0;
};

/**
 * Reads a paged file. Checks the checksum of every page that it reads from disk, and the sum of its
 * group, if the file has sums: then the first page of a group costs a read of 8 bytes for each other
 * page of it. Keeps pages in a least-recently-used cache of at most `cacheBytes` bytes (0: none),
 * overhead included; besides, 8 bytes for each page of the groups it has read from, if a group has
 * several. Any number of threads may read at once.
 *
 * Errors: Corrupt (not a paged file, another kind, truncated, longer than its header says, altered;
 * the message names file, page and reason), Unsupported (a newer format version), those of the
 * file.
 */
class PagedFileReader
{
public:
  /// The payload of a page and its checksum. Valid as long as it is held.
  using Page = std::shared_ptr<const std::vector<std::uint8_t>>;

  /// Reads and checks page 0. Takes ownership of the file.
  static Result<std::unique_ptr<PagedFileReader>> Open(
    std::unique_ptr<RandomAccessFile> file, const PagedFile::Kind& kind, std::size_t cacheBytes);

  std::uint32_t GetPageSize() const { return this->PageSize; }
  std::size_t GetPayloadSize() const { return this->PageSize - PagedFile::ChecksumSize; }
  std::uint64_t GetPageCount() const { return this->PageCount; }
  const PagedFile::ClientArea& GetClientArea() const { return this->ClientArea; }
  const std::string& GetPath() const { return this->File->GetPath(); }

  /// Corrupt unless the file has sums, and its seal is this one (PagedFileWriter::GetSeal()).
  Status CheckSeal(std::uint64_t seal) const;

  /// Reads a page, or takes it from the cache; counts that in `statistics`.
  Result<Page> ReadPage(std::uint64_t page, PageStatistics& statistics) const;

  /// An error that names this file and one of its pages.
  Status MakeCorrupt(std::uint64_t page, const std::string& reason) const;

private:
  explicit PagedFileReader(std::unique_ptr<RandomAccessFile> file);
  Status ReadHeader(const PagedFile::Kind& kind);
  Status TakeSums(const std::vector<std::uint8_t>& first);
  Result<Page> ReadFromDisk(std::uint64_t page) const;
  /// Corrupt if the pages of a page's group are not those that were written.
  Status CheckGroup(std::uint64_t page, std::uint64_t checksum) const;
  Page FindInCache(std::uint64_t page) const;
  void PutIntoCache(std::uint64_t page, const Page& bytes) const;

  struct CacheEntry
  {
    std::uint64_t Number;
    Page Bytes;
  };
  using CacheList = std::list<CacheEntry>;

  std::unique_ptr<RandomAccessFile> File;
  std::uint32_t PageSize = 0;
  std::uint64_t PageCount = 0;
  PagedFile::ClientArea ClientArea = {};
  std::uint64_t Seal = 0;
  std::uint64_t GroupSize = 0;     // 0: the file has no sums
  std::vector<std::uint64_t> Sums; // by group
  std::size_t CachePages = 0;
  mutable std::mutex CacheMutex;
  mutable CacheList Cache; // the most recently used page first
  mutable std::unordered_map<std::uint64_t, CacheList::iterator> CacheIndex;
  /// The checksums of the pages of groups of several that match their sums.
  mutable std::unordered_map<std::uint64_t, std::vector<std::uint64_t>> KnownGroups;
};

} // namespace isosurface

#endif
