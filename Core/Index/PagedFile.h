// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PagedFile_h
#define isosurface_PagedFile_h

#include "Base/FileSystem.h"
#include "Base/Status.h"

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

/// What the pages of one or several queries cost.
struct PageStatistics
{
  std::uint64_t PageReads = 0; ///< pages read from disk
  std::uint64_t CacheHits = 0; ///< pages found in the reader's cache
};

/**
 * A file of pages of one size (4096, 8192 or 16384 bytes), each with its own checksum, so that any
 * page can be read and trusted alone. Page 0 tells what the file is; pages 1 .. n - 1 belong to the
 * user of the file. All numbers are little-endian.
 *
 *     page 0                                        page p
 *     +------+--------------------------------+     +------+--------------------------------+
 *     |    0 | magic "ISOPAGED"               |     |    0 | payload, PageSize - 8 bytes    |
 *     |    8 | format version     (uint32)    |     |  ... |                                |
 *     |   12 | page size in bytes (uint32)    |     | PageSize - 8 : checksum (uint64)      |
 *     |   16 | number of pages    (uint64)    |     +------+--------------------------------+
 *     |   24 | kind, 8 characters             |
 *     |   32 | client area, 256 bytes         |     checksum = XXH3-64 of the payload, with the
 *     |  288 | zeros                          |     page's number as seed: a page in a wrong place
 *     | PageSize - 8 : checksum (uint64)      |     is recognised like a page with wrong bytes.
 *     +------+--------------------------------+
 */
struct PagedFile
{
  static constexpr std::uint32_t FormatVersion = 1;
  static constexpr std::uint32_t DefaultPageSize = 4096;
  static constexpr std::size_t ChecksumSize = 8;
  static constexpr std::size_t ClientAreaSize = 256;

  /// Eight characters that say what the pages hold.
  using Kind = std::array<char, 8>;
  /// Bytes of page 0 that belong to the user of the file.
  using ClientArea = std::array<std::uint8_t, ClientAreaSize>;

  static bool IsPageSize(std::uint64_t size)
  {
    return size == 4096 || size == 8192 || size == 16384;
  }
};

/**
 * Writes a paged file. Pages are allocated in order and may be written in any order; page 0 is
 * written by Finish(), so that a file without it never opens as valid. Memory: WriteBehindSize
 * bytes, by which neighbouring pages reach the disk in one write.
 */
class PagedFileWriter
{
public:
  static constexpr std::size_t WriteBehindSize = 64 * 1024;

  /// Creates the file. Errors: InvalidArgument for another page size, those of CreateForWriting.
  static Result<std::unique_ptr<PagedFileWriter>> Create(FileSystem& fileSystem,
    const std::string& path, std::uint32_t pageSize, const PagedFile::Kind& kind);

  std::uint32_t GetPageSize() const { return this->PageSize; }
  std::size_t GetPayloadSize() const { return this->PageSize - PagedFile::ChecksumSize; }
  std::uint64_t GetPageCount() const { return this->PageCount; }

  /// The number of a new page at the end. The page must be written once before Finish().
  Result<std::uint32_t> AllocatePage();
  /// Writes GetPayloadSize() bytes as the payload of an allocated page, and its checksum.
  Status WritePage(std::uint32_t page, const std::uint8_t* payload);
  /// Writes page 0, then brings the file to stable storage and closes it.
  Status Finish(const PagedFile::ClientArea& clientArea);

private:
  PagedFileWriter(
    std::unique_ptr<WritableFile> file, std::uint32_t pageSize, const PagedFile::Kind& kind);
  Status Flush();
  void Seal(std::uint64_t page, std::uint8_t* bytes) const;

  std::unique_ptr<WritableFile> File;
  std::uint32_t PageSize;
  PagedFile::Kind Kind;
  std::uint64_t PageCount = 0;
  std::uint64_t FlushedPages = 0;
  std::vector<std::uint8_t> Pending; // pages FlushedPages .. PageCount - 1
  std::vector<std::uint8_t> Scratch; // one page
};

/**
 * Reads a paged file. Every page's checksum is verified when it comes from disk. Pages are kept in
 * a least-recently-used cache of at most `cacheBytes` bytes (0: none), overhead included. Any
 * number of threads may read at once.
 *
 * Errors: Corrupt (not such a file, another kind, truncated, longer than it says, altered; names
 * file, page and reason), Unsupported (a newer format version), those of the file.
 */
class PagedFileReader
{
public:
  /// The payload of a page and its checksum; stays valid as long as someone holds it.
  using Page = std::shared_ptr<const std::vector<std::uint8_t>>;

  /// Reads and checks page 0. Owns the file from now on.
  static Result<std::unique_ptr<PagedFileReader>> Open(
    std::unique_ptr<RandomAccessFile> file, const PagedFile::Kind& kind, std::size_t cacheBytes);

  std::uint32_t GetPageSize() const { return this->PageSize; }
  std::size_t GetPayloadSize() const { return this->PageSize - PagedFile::ChecksumSize; }
  std::uint64_t GetPageCount() const { return this->PageCount; }
  const PagedFile::ClientArea& GetClientArea() const { return this->ClientArea; }
  const std::string& GetPath() const { return this->File->GetPath(); }

  /// Costs one page read, or none if the page is in the cache; counted in `statistics`.
  Result<Page> ReadPage(std::uint64_t page, PageStatistics& statistics) const;

  /// An error that names this file and one of its pages.
  Status MakeCorrupt(std::uint64_t page, const std::string& reason) const;

private:
  explicit PagedFileReader(std::unique_ptr<RandomAccessFile> file);
  Status ReadHeader(const PagedFile::Kind& kind);
  Result<Page> ReadFromDisk(std::uint64_t page) const;
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
  std::size_t CachePages = 0;
  mutable std::mutex CacheMutex;
  mutable CacheList Cache; // the most recently used page first
  mutable std::unordered_map<std::uint64_t, CacheList::iterator> CacheIndex;
};

} // namespace isosurface

#endif
