// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexWriteJob_h
#define isosurface_EdgeIndexWriteJob_h

#include "Coding/EdgeIndex/EdgeIndexDirectory.h"
#include "Coding/EdgeIndex/EdgeIndexEncoder.h"
#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// Records of the preview are written when they reach this size.
constexpr std::size_t MaximumEdgeIndexPreviewBytes = std::size_t{ 1 } << 20;

/// The name of a file until it is complete.
inline std::string GetPartialEdgeIndexPath(const std::string& path)
{
  return path + ".part";
}

/// Locks the partial file of `path`, which is the first step of writing. Errors: those of LockFile;
/// IoError if what is at the path is no regular file.
Result<std::unique_ptr<PathLock>> LockEdgeIndexFile(FileSystem& files, const std::string& path);

/// Renames a complete file from GetPartialEdgeIndexPath(path) to `path`, durably. Releases the lock as soon as
/// it is renamed: from then on a partial file is another writer's.
Status PutEdgeIndexFileInPlace(
  FileSystem& files, const std::string& path, std::unique_ptr<PathLock>& lock);

/// What was written; the same on all ranks.
struct EdgeIndexFileSummary
{
  std::uint64_t Records = 0; ///< without those of the preview
  std::uint64_t Points = 0;  ///< crossed edges, counted in each block that has them
  std::uint64_t Bytes = 0;
};

/**
 * Writes the surface of all ranks' blocks as one edge-index file, in rounds. Each rank encodes blocks
 * until its memory is full; all agree up to which block everything is encoded, exchange the sizes of
 * the records up to there, and write their own ones at once. Rank 0 adds the directory.
 *
 * The file has the blocks in the order of their numbers and is, byte for byte, what
 * a writer on one rank makes of these records, for any number of ranks. It is renamed when complete; if
 * any rank fails, an older file stays. Rank 0 keeps the partial file locked: a second job to the same
 * path fails at once.
 *
 * Memory of a rank: MemoryBytes of records, plus those of 64 blocks, an encoder and a block for each
 * thread; on rank 0 about 100 bytes for each record. A rank with full memory waits for the others.
 */
class EdgeIndexWriteJob
{
public:
  struct Settings
  {
    int Threads = 1;
    std::uint64_t MemoryBytes = std::uint64_t{ 256 } << 20;
    /// Called on rank 0, before anything is written, if the disk has not the room that the file will
    /// take, as far as the blocks that are encoded by then tell.
    std::function<void(const std::string& warning)> Warn = nullptr;
  };

  /**
   * numbers: of the source's blocks, in their order, ascending; no two blocks of all ranks have the
   * same number. The header is the same on all ranks; its NumberOfBlocks is set to that of all
   * blocks. The references must outlive the job.
   */
  EdgeIndexWriteJob(Communicator& ranks, FileSystem& files, std::string path,
    const EdgeIndexHeader& header, BlockSource& source, const std::vector<std::int64_t>& numbers,
    const Settings& settings);

  /// Collective. Errors of any rank: InvalidArgument, what Acquire or the file system returns,
  /// OutOfMemory, Aborted. `progress` is that of this rank's blocks.
  Result<EdgeIndexFileSummary> Run(const Progress& progress = {});

private:
  /// The encoded records of a block that are not written yet.
  struct PendingBlock
  {
    std::int64_t Number = 0;
    std::vector<std::uint8_t> Bytes;
  };

  struct RoundBlock; ///< the records of a block of any rank, as that rank described them

  Status Begin();
  Status WriteRounds(const Progress& progress);
  Status WriteHeader();
  Status EncodeAhead(const Progress& progress);
  Status EncodeBatch(std::size_t size, const Progress& progress);
  Message DescribeBlocks(std::int64_t end) const;
  Status ParseBlocks(const Message& message, int rank, std::vector<RoundBlock>& blocks) const;
  Status WriteRound(std::int64_t end);
  Status PlaceBlock(const RoundBlock& block, const std::uint8_t* bytes);
  Status FlushPreview();
  Status Place(const EdgeIndexEntry& entry, const std::uint8_t* bytes, std::size_t size);
  Status FlushOutput();
  Status Finish();

  Communicator& Ranks;
  FileSystem& Files;
  std::string Path;
  EdgeIndexHeader Header;
  BlockSource& Source;
  const std::vector<std::int64_t>& Numbers;
  Settings Wanted;

  std::vector<std::uint8_t> HeaderBytes;
  std::unique_ptr<PathLock> Lock; ///< of the partial file, on rank 0
  std::unique_ptr<WritableFile> File;
  std::vector<std::unique_ptr<EdgeIndexEncoder>> Encoders; ///< one a thread
  std::size_t NextBlock = 0; ///< of the source, the next one to encode
  std::deque<PendingBlock> Pending;
  std::uint64_t PendingBytes = 0;

  std::uint64_t Offset = 0;             ///< of the next record
  std::vector<EdgeIndexEntry> Entries;  ///< records that have their offsets; on rank 0 only
  std::vector<EdgeIndexEntry> Previews; ///< records of the preview that have no offset yet
  std::uint64_t PreviewBytes = 0;
  std::vector<std::vector<std::uint8_t>>
    OwnPreviews;                    ///< bytes of Previews; empty for other ranks' records
  std::vector<std::uint8_t> Output; ///< own records that are adjacent in the file ...
  std::uint64_t OutputOffset = 0;   ///< ... from here on
  EdgeIndexFileSummary Summary;
};

} // namespace isosurface

#endif
