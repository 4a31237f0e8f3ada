// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockDirectory_h
#define isosurface_BlockDirectory_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/PagedFile.h"
#include "Ground/Base/Status.h"
#include "Storage/Store/QueryStatistics.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// Where a block of a store is in the file `blocks`, and the lengths of its segments.
struct BlockDirectoryEntry
{
  std::int64_t Block = 0;
  std::uint64_t Offset = 0;
  /// Bytes stored in each segment, without its header, in the order of the record (components,
  /// coarsest level first).
  std::vector<std::uint32_t> Lengths;

  /// Bytes from the record's start to a segment's header.
  std::uint64_t FindSegment(std::size_t segment) const;
};

/// Where the samples of a store's records are.
enum class SamplePlace : std::uint8_t
{
  Store, ///< in the records
  Source ///< in the volume's source: a record has the headers of its segments alone, without padding
};

/**
 * The file `directory` of a store: one entry a block, in the order of their ordinals, in a paged
 * file (PagedFile.h) of kind "BLOCKDIR". Page p has the entries (p - 1) * n to p * n - 1, with n
 * the number that fit its payload:
 *
 *     page 0, client area                    entry
 *     +----+------------------------------+  +----+-------------------------------------------+
 *     |  0 | number of entries   (uint64) |  |  0 | block index                      (uint64) |
 *     |  8 | segments an entry s (uint32) |  |  8 | offset of the record in `blocks` (uint64) |
 *     | 12 | zeros (uint32)               |  | 16 | bytes stored of each segment (s x uint32) |
 *     | 16 | store's checksum    (uint64) |  +----+-------------------------------------------+
 *     | 24 | zeros                        |
 *     +----+------------------------------+
 */
class BlockDirectory
{
public:
  /// The maximum number of segments (components times levels) of an entry, by the page size.
  static constexpr std::size_t MaximumSegments = (16384 - PagedFile::ChecksumSize - 16) / 4;

  /// `identity`: the checksum of the store, which the header has too. Returns the file's seal.
  static Result<std::uint64_t> Write(FileSystem& fileSystem, const std::string& path,
    std::size_t segments, std::uint64_t identity, const std::vector<BlockDirectoryEntry>& entries);

  /// Reads page 0. Corrupt if the file has other numbers of entries or segments, or is that of
  /// another store.
  static Result<std::unique_ptr<BlockDirectory>> Open(FileSystem& fileSystem,
    const std::string& path, std::uint64_t entries, std::size_t segments, std::uint64_t identity,
    std::size_t cacheBytes, SamplePlace place = SamplePlace::Store);

  std::uint64_t GetCount() const { return this->Count; }
  const std::string& GetPath() const { return this->File->GetPath(); }
  /// Corrupt unless the file is the one that Write() gave this seal.
  Status CheckSeal(std::uint64_t seal) const { return this->File->CheckSeal(seal); }

  /// Cost: at most one page read. Corrupt unless the entry's block is below `blocks` and its record
  /// within `fileSize`.
  Result<BlockDirectoryEntry> Read(std::uint64_t ordinal, std::int64_t blocks,
    std::uint64_t fileSize, QueryStatistics& statistics) const;

private:
  BlockDirectory(std::unique_ptr<PagedFileReader> file, std::uint64_t count, std::size_t segments,
    SamplePlace place);

  std::unique_ptr<PagedFileReader> File;
  std::uint64_t Count;
  std::size_t Segments;
  SamplePlace Place;
};

} // namespace isosurface

#endif
