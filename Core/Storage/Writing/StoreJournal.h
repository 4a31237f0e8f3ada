// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreJournal_h
#define isosurface_StoreJournal_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ValueKey.h"
#include "Storage/Store/BlockDirectory.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// Where the files of an unfinished store end, and what was counted of its blocks.
struct StoreCheckpoint
{
  std::uint64_t BlocksBytes = 0;      ///< of the file of records
  std::uint64_t BlocksChecksum = 0;   ///< BlockStoreWriter::GetChecksum()
  std::uint64_t BlocksSum = 0;        ///< AppendedSum of the file of records
  std::uint64_t OverviewBytes = 0;    ///< of the samples of the next overview
  std::uint64_t OverviewSum = 0;      ///< AppendedSum of these samples
  std::vector<KeyRange> FiniteRanges; ///< per variable
  std::vector<std::uint8_t> Spectra;  ///< StoreSpectra::PackSums()
};

/// A checksum of what was appended to a file, portion by portion.
class AppendedSum
{
public:
  AppendedSum() = default;
  explicit AppendedSum(std::uint64_t sum)
    : Sum(sum)
  {
  }
  void Add(const void* bytes, std::size_t size);
  std::uint64_t Get() const { return this->Sum; }

  /// Corrupt unless the file begins with the same portions, which end at these offsets. Cost: reading
  /// them.
  Status Check(
    FileSystem& files, const std::string& path, const std::vector<std::uint64_t>& ends) const;

private:
  std::uint64_t Sum = 0;
};

/**
 * Keeps what is in memory of a store that is being written: temporary files in the store's folder.
 * `entries.tmp` has the directory's entry and the value ranges of each block, and grows with each
 * checkpoint. The checkpoints themselves are written in turn to `checkpoint-0.tmp` and
 * `checkpoint-1.tmp`, so that the one before stays until that of all stores is complete
 * (WriteJournal). Checksums cover both. Nothing else may use the files meanwhile.
 */
class StoreJournal
{
public:
  StoreJournal(FileSystem& files, std::string folder)
    : Files(files)
    , Folder(std::move(folder))
  {
  }

  /// Adds checkpoint `number` and brings it to stable storage. `entries`: of all blocks of the store
  /// so far; ranges[variable][block]: the value ranges of all blocks of the volume. Cost: writing
  /// what came after the last checkpoint, and 64 KiB a spectrum.
  Status Add(std::int64_t number, const StoreCheckpoint& checkpoint,
    const std::vector<BlockDirectoryEntry>& entries,
    const std::vector<std::vector<KeyRange>>& ranges);

  /// Reads checkpoint `number`, and sets the entries, of `segments` lengths each, and the ranges of
  /// their blocks. Add() goes on there. An error, mostly Corrupt, if there is no such checkpoint.
  Result<StoreCheckpoint> Take(std::int64_t number, std::size_t segments,
    std::vector<BlockDirectoryEntry>& entries, std::vector<std::vector<KeyRange>>& ranges);

  /// Removes the files.
  static Status Remove(FileSystem& files, const std::string& folder);

private:
  std::string GetEntriesPath() const { return this->Folder + "/entries.tmp"; }
  static std::string GetCheckpointPath(const std::string& folder, std::int64_t number)
  {
    return folder + "/checkpoint-" + std::to_string(number % 2) + ".tmp";
  }
  Status AppendEntries(const std::vector<BlockDirectoryEntry>& entries,
    const std::vector<std::vector<KeyRange>>& ranges);
  Status ReadEntries(std::size_t segments, std::vector<BlockDirectoryEntry>& entries,
    std::vector<std::vector<KeyRange>>& ranges);

  FileSystem& Files;
  std::string Folder;
  std::unique_ptr<WritableFile> Entries; ///< null before the first checkpoint
  std::uint64_t EntriesBytes = 0;
  std::uint64_t EntriesChecksum = 0;
  std::size_t Count = 0; ///< of entries in the file
};

} // namespace isosurface

#endif
