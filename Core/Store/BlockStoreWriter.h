// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockStoreWriter_h
#define isosurface_BlockStoreWriter_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Store/BlockDirectory.h"
#include "Store/BlockExchange.h"
#include "Store/BlockedVolumeHeader.h"
#include "Volume/ValueKey.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// Where the next block of a lane (RoundPlan.h) goes in a store.
struct StoreCursor
{
  std::uint64_t Ordinal = 0;
  std::uint64_t Offset = 0;
};

/**
 * Writes one store: Write() its blocks, those of a lane in the order of their indices, then
 * Finish(). The files are those that BlockStore.h names; they do not depend on the lanes, since
 * a block's place follows from the sizes of the records before it. Memory: one directory entry and
 * the segments' checksums a block; for the trees what Finish() is allowed.
 */
class BlockStoreWriter
{
public:
  /// Creates the folder and the file of records, each of so many segments (arrays times levels).
  /// `cursors`: where each lane begins, and last where the store ends.
  static Result<std::unique_ptr<BlockStoreWriter>> Create(FileSystem& files,
    const std::string& folder, std::size_t segments, std::vector<StoreCursor> cursors);

  /// Writes a record whose segments are sealed.
  Status Write(const PendingBlock& block, std::size_t lane);

  /// Writes the directory and the trees, brings all to stable storage. ranges[array][block] are the
  /// value ranges of all blocks of the volume.
  Result<StoreDescription> Finish(
    const std::vector<std::vector<KeyRange>>& ranges, std::size_t memoryBytes);

  /// The memory of a block's entry.
  static std::uint64_t GetEntryBytes(std::size_t segments)
  {
    return sizeof(BlockDirectoryEntry) + (4 + sizeof(std::uint64_t)) * segments + 16;
  }

private:
  BlockStoreWriter(FileSystem& files, std::string folder, std::size_t segments,
    std::unique_ptr<WritableFile> blocks, std::vector<StoreCursor> cursors);
  std::uint64_t ChainChecksums() const;
  Status WriteTree(
    std::size_t array, const std::vector<KeyRange>& ranges, std::size_t memoryBytes) const;

  FileSystem& Files;
  std::string Folder;
  std::size_t Segments;
  std::unique_ptr<WritableFile> Blocks;
  std::vector<BlockDirectoryEntry> Entries;
  std::vector<StoreCursor> Cursors;
  std::vector<std::uint64_t> Checksums; ///< per block and segment
};

} // namespace isosurface

#endif
