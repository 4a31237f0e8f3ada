// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockStoreWriter_h
#define isosurface_BlockStoreWriter_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ValueKey.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Writing/BlockExchange.h"
#include "Storage/Writing/StoreJournal.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// Writes one store: Append() its blocks in the order of their ordinals, then Finish().
/// BlockStore.h names the files. Memory: one directory entry a block, and the limit of Finish() for
/// the trees.
class BlockStoreWriter
{
public:
  /// Creates the folder and the file of records, for `blocks` blocks of `segments` segments
  /// (components times levels) each. `place`: if the samples are in the volume's source, records are
  /// stored without them.
  static Result<std::unique_ptr<BlockStoreWriter>> Create(FileSystem& files,
    const std::string& folder, std::size_t segments, std::size_t blocks, SamplePlace place);

  /// Goes on with a store whose first `entries` were appended by another writer, as it left them in
  /// `checkpoint`. Corrupt if the records are not those.
  static Result<std::unique_ptr<BlockStoreWriter>> Open(FileSystem& files,
    const std::string& folder, std::size_t segments, std::size_t blocks, SamplePlace place,
    std::vector<BlockDirectoryEntry> entries, const StoreCheckpoint& checkpoint);

  /// Appends a record whose segments are sealed.
  Status Append(const PendingBlock& block);

  /// Of the blocks appended so far, in the order of their ordinals.
  const std::vector<BlockDirectoryEntry>& GetEntries() const { return this->Entries; }

  /// Of the records appended so far.
  std::uint64_t GetBytes() const { return this->Blocks->GetSize(); }
  std::uint64_t GetChecksum() const { return this->Checksum; }
  const AppendedSum& GetSum() const { return this->Sum; }
  /// Brings the records appended so far to stable storage.
  Status Sync() { return this->Blocks->Sync(); }

  /// Writes the directory and the trees, and brings all files to stable storage.
  /// ranges[variable][block]: the value ranges of all blocks of the volume.
  Result<StoreDescription> Finish(const ArrayVariables& variables,
    const std::vector<std::vector<KeyRange>>& ranges, std::size_t memoryBytes);

  /// The memory of a block's entry.
  static std::uint64_t GetEntryBytes(std::size_t segments)
  {
    return sizeof(BlockDirectoryEntry) + 4 * segments + 16;
  }

private:
  BlockStoreWriter(FileSystem& files, std::string folder, std::size_t segments,
    std::unique_ptr<WritableFile> blocksFile, std::size_t blocks, SamplePlace place);
  Status AppendHeaders(const PendingBlock& block);
  Status AppendBytes(const std::uint8_t* bytes, std::size_t size);
  /// Returns the tree's seal.
  Result<std::uint64_t> WriteTree(const std::string& path, std::uint64_t identity,
    const std::vector<KeyRange>& ranges, std::size_t memoryBytes) const;

  FileSystem& Files;
  std::string Folder;
  std::size_t Segments;
  SamplePlace Place;
  std::unique_ptr<WritableFile> Blocks;
  std::vector<BlockDirectoryEntry> Entries;
  std::uint64_t Checksum = 0;
  AppendedSum Sum; ///< of the file of records
};

} // namespace isosurface

#endif
