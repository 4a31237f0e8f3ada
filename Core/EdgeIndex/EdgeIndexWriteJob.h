// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexWriteJob_h
#define isosurface_EdgeIndexWriteJob_h

#include "Base/Communicator.h"
#include "Base/FileSystem.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "EdgeIndex/EdgeIndexDirectory.h"
#include "EdgeIndex/EdgeIndexEncoder.h"
#include "EdgeIndex/EdgeIndexHeader.h"
#include "Volume/BlockSource.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// What a file was written of, and how large it became; the same on all ranks.
struct EdgeIndexFileSummary
{
  std::uint64_t Records = 0; ///< of the surface; those of the preview not counted
  std::uint64_t Points = 0;  ///< crossed edges of the blocks, shared ones once a block
  std::uint64_t Bytes = 0;
};

/**
 * Writes the surface of the blocks of all ranks as one edge-index file, in rounds: each rank
 * encodes blocks of its own until its memory is full, all agree up to which block everything is
 * encoded, tell each other the sizes of the records up to there, and write their own ones to their
 * places, at once. Rank 0 adds the directory.
 *
 * Blocks stand in the order of their numbers, which the ranks have in common, whoever has them: the
 * file is, byte for byte, what EdgeIndexFileWriter makes of the records in that order. It appears
 * in one step (see there); if any rank fails, what was there before stays.
 *
 * Memory of a rank: `memoryBytes` of records, with those of 16 blocks a thread that come on top, an
 * encoder and a block a thread; on rank 0 about 100 bytes a record. A rank whose blocks all come
 * late in the file waits, once its memory is full, for those of the others.
 */
class EdgeIndexWriteJob
{
public:
  struct Settings
  {
    int Threads = 1;
    std::uint64_t MemoryBytes = std::uint64_t{ 256 } << 20;
  };

  /**
   * numbers: of the source's blocks, in their order, ascending; no two blocks of any ranks have the
   * same one. The header is the same on all ranks; its NumberOfBlocks becomes that of all blocks.
   * The references must outlive the job.
   */
  EdgeIndexWriteJob(Communicator& ranks, FileSystem& files, std::string path,
    const EdgeIndexHeader& header, BlockSource& source, const std::vector<std::int64_t>& numbers,
    const Settings& settings);

  /// Collective. Errors, of any rank: InvalidArgument, what Acquire or the file system returns,
  /// OutOfMemory, Aborted. Progress is told of this rank's blocks.
  Result<EdgeIndexFileSummary> Run(const Progress& progress = {});

private:
  /// The records of a block that are encoded and not written yet.
  struct PendingBlock
  {
    std::int64_t Number = 0;
    std::vector<std::uint8_t> Bytes;
  };

  struct RoundBlock; ///< the records of a block of any rank's, as it told the others

  Status Begin();
  Status WriteRounds(const Progress& progress);
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
  std::unique_ptr<WritableFile> File;
  std::vector<std::unique_ptr<EdgeIndexEncoder>> Encoders; ///< one a thread
  std::size_t NextBlock = 0;                               ///< of the source, to be encoded
  std::deque<PendingBlock> Pending;
  std::uint64_t PendingBytes = 0;

  std::uint64_t Offset = 0;             ///< of the next record
  std::vector<EdgeIndexEntry> Entries;  ///< of what has its place; on rank 0
  std::vector<EdgeIndexEntry> Previews; ///< of what is kept back, in their order
  std::uint64_t PreviewBytes = 0;
  std::vector<std::vector<std::uint8_t>> OwnPreviews; ///< bytes of Previews; empty if not ours
  std::vector<std::uint8_t> Output;                   ///< own records that follow each other ...
  std::uint64_t OutputOffset = 0;                     ///< ... from here on
  EdgeIndexFileSummary Summary;
};

} // namespace isosurface

#endif
