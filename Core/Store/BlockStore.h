// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockStore_h
#define isosurface_BlockStore_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Index/ExternalIntervalTree.h"
#include "Store/BlockCache.h"
#include "Store/BlockDirectory.h"
#include "Store/BlockedVolumeHeader.h"
#include "Store/QueryStatistics.h"
#include "Volume/BlockGrid.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * One store of one time step, opened for reading: a folder with the files
 *
 *     blocks          the records (BlockRecord.h)
 *     directory       where they are (BlockDirectory.h)
 *     array-N.tree    per variable: the external interval tree over the blocks' value ranges
 *                     (ExternalIntervalTree.h); payload = the block's ordinal. Of an array of
 *                     several components: array-N-component-C.tree, array-N-magnitude.tree
 *
 * The folder may be a link or a mount point, so that each store has a disk of its own. A tree is
 * opened at the first query of its variable. Any number of threads may use one store at once.
 */
class BlockStore
{
public:
  /// Of the pages of the directory and of each tree, so many bytes are kept in memory.
  static constexpr std::size_t PageCacheBytes = 1024 * 1024;

  static std::string GetBlocksPath(const std::string& folder) { return folder + "/blocks"; }
  static std::string GetDirectoryPath(const std::string& folder) { return folder + "/directory"; }
  static std::string GetTreePath(
    const std::string& folder, const ArrayVariables& variables, std::size_t variable);

  /// Opens the records and the directory. A missing folder is NotFound; files that do not fit
  /// `description` are Corrupt.
  static Result<std::shared_ptr<BlockStore>> Open(FileSystem& files, const std::string& folder,
    const BlockedVolumeHeader& header, const StoreDescription& description);

  std::uint64_t GetNumberOfBlocks() const { return this->Directory->GetCount(); }

  /// The ordinals of the blocks that an isosurface of one of the isovalues passes, ascending.
  Result<std::vector<std::uint32_t>> FindActive(
    std::size_t variable, const std::vector<double>& isovalues, QueryStatistics& statistics);

  /// The ordinals of the blocks of which all samples are inside for one of the isovalues,
  /// ascending. Cost: a range query for all blocks with samples inside.
  Result<std::vector<std::uint32_t>> FindInside(
    std::size_t variable, const std::vector<double>& isovalues, QueryStatistics& statistics);

  /// The grid's index of a block.
  Result<std::int64_t> FindBlock(std::uint32_t ordinal, QueryStatistics& statistics) const;

  /// Reads one component of a block up to a level, by one read, and decodes it. Corrupt if the
  /// ordinal is not that of `block`.
  Result<std::shared_ptr<const DecodedBlock>> Read(std::uint32_t ordinal, std::int64_t block,
    std::size_t variable, int level, QueryStatistics& statistics) const;

  /// The same for the components [first, first + count) of the variables, by one read, which skips
  /// nothing: at a coarser level than 0 it has the finer levels of all but the last one in it.
  Result<DecodedBlocks> ReadAdjacent(std::uint32_t ordinal, std::int64_t block, std::size_t first,
    std::size_t count, int level, QueryStatistics& statistics) const;

  /// A part of the file of records.
  struct ByteRange
  {
    std::uint64_t Begin;
    std::uint64_t End;
  };

  /// What ReadAdjacent would read; nothing if the directory's entry is damaged.
  std::optional<ByteRange> FindAdjacent(
    std::uint32_t ordinal, std::size_t first, std::size_t count, int level) const;

  /// Starts reading, without waiting for it, ranges by ascending begin; those that touch, but for
  /// the padding between records, as one.
  void Prefetch(const std::vector<ByteRange>& ranges) const;

private:
  BlockStore(FileSystem& files, std::string folder, const BlockedVolumeHeader& header);
  Result<const ExternalIntervalTree*> GetTree(std::size_t variable);
  Status MakeError(StatusCode code, const std::string& reason) const;
  Status CheckLengths(const BlockDirectoryEntry& entry, std::size_t variable, int level) const;
  /// `segment`: those of the levels from the coarsest to `level`, as they are on disk.
  Result<std::shared_ptr<const DecodedBlock>> Decode(const BlockDirectoryEntry& entry,
    std::size_t variable, int level, const std::uint8_t* segment) const;

  FileSystem& Files;
  std::string Folder;
  ArrayVariables Variables;
  BlockGrid Grid;
  std::unique_ptr<RandomAccessFile> Blocks;
  std::unique_ptr<BlockDirectory> Directory;
  std::mutex TreeMutex;
  std::vector<std::unique_ptr<ExternalIntervalTree>> Trees;
};

} // namespace isosurface

#endif
