// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockDirectory_h
#define isosurface_BlockDirectory_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Index/PagedFile.h"
#include "Store/QueryStatistics.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// Where a block of a store stands in the file `blocks`, and how long its segments are.
struct BlockDirectoryEntry
{
  std::int64_t Block = 0;
  std::uint64_t Offset = 0;
  /// Bytes stored in each segment, without its header, in the order of the record (array by array,
  /// coarsest level first).
  std::vector<std::uint32_t> Lengths;

  /// Bytes from the record's begin to a segment's header.
  std::uint64_t FindSegment(std::size_t segment) const;
};

// clang-format off
/**
 * The file `directory` of a store: one entry a block, in the order of their ordinals, in a paged
 * file (PagedFile.h) of kind "BLOCKDIR". Entries do not cross pages:
 *
 *     page 0, client area                   page p: entries (p - 1) * n, ..., n = floor(payload / size)
 *     +----+-----------------------------+ +----+-------------------------------------------------+
 *     |  0 | number of entries  (uint64) |  |  0 | block index                       (uint64)     |
 *     |  8 | segments an entry  (uint32) |  |  8 | offset of the record in `blocks`  (uint64)     |
 *     | 12 | zeros                       |  | 16 | bytes stored, of each segment     (uint32 each)|
 *     +----+-----------------------------+ +----+-------------------------------------------------+
 */
// clang-format on
class BlockDirectory
{
public:
  /// More segments (arrays times levels) than this do not fit the largest page.
  static constexpr std::size_t MaximumSegments = (16384 - PagedFile::ChecksumSize - 16) / 4;

  static Status Write(FileSystem& fileSystem, const std::string& path, std::size_t segments,
    const std::vector<BlockDirectoryEntry>& entries);

  /// Reads page 0. A file with other numbers of entries or segments is Corrupt.
  static Result<std::unique_ptr<BlockDirectory>> Open(FileSystem& fileSystem,
    const std::string& path, std::uint64_t entries, std::size_t segments, std::size_t cacheBytes);

  std::uint64_t GetCount() const { return this->Count; }
  const std::string& GetPath() const { return this->File->GetPath(); }

  /// Costs at most one page read. The entry's block is below `blocks`, its record within
  /// `fileSize`; else it is Corrupt.
  Result<BlockDirectoryEntry> Read(std::uint64_t ordinal, std::int64_t blocks,
    std::uint64_t fileSize, QueryStatistics& statistics) const;

private:
  BlockDirectory(std::unique_ptr<PagedFileReader> file, std::uint64_t count, std::size_t segments);

  std::unique_ptr<PagedFileReader> File;
  std::uint64_t Count;
  std::size_t Segments;
};

} // namespace isosurface

#endif
