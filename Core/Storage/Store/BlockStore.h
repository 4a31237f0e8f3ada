// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockStore_h
#define isosurface_BlockStore_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Storage/Index/ExternalIntervalTree.h"
#include "Storage/Store/BlockCache.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/QueryStatistics.h"
#include "Storage/Store/StoreRecords.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

class SourceSamples;

/**
 * One store of one time step, opened for reading: a folder with the files
 *
 *     blocks          the records (BlockRecord.h)
 *     directory       where they are (BlockDirectory.h)
 *     array-N.tree    the external interval tree over the blocks' value ranges of an array
 *                     (ExternalIntervalTree.h); payload = the block's ordinal. An array of several
 *                     components has array-N-component-C.tree and array-N-magnitude.tree instead.
 *
 * The folder may be a link or a mount point, so that each store has a disk of its own. A tree is
 * opened at the first query of its variable. Safe for any number of threads.
 */
class BlockStore
{
public:
  /// The bytes of pages that the directory and each tree keep in memory.
  static constexpr std::size_t PageCacheBytes = 1024 * 1024;

  static std::string GetDirectoryPath(const std::string& folder) { return folder + "/directory"; }
  static std::string GetTreePath(
    const std::string& folder, const ArrayVariables& variables, std::size_t variable);
  /// The paths of all files.
  static std::vector<std::string> ListPaths(
    const std::string& folder, const ArrayVariables& variables);

  /// The identity in the header of a variable's tree: of the records of this store of this time step,
  /// whose checksum the description has, and of the variable.
  static std::uint64_t GetTreeIdentity(const StoreDescription& description, std::size_t variable);
  /// Corrupt unless the tree is that of the store and the variable, as it was written.
  static Status CheckTree(
    const ExternalIntervalTree& tree, const StoreDescription& description, std::size_t variable);
  /// The directory of a store of `segments` segments a block, as it was written.
  static Result<std::unique_ptr<BlockDirectory>> OpenDirectory(FileSystem& files,
    const std::string& folder, const StoreDescription& description, std::size_t segments,
    SamplePlace place);

  /// Opens the records and the directory. NotFound if the folder is missing, Corrupt if the files
  /// do not fit `description`. `source`: the samples of a volume in place, else null.
  static Result<std::shared_ptr<BlockStore>> Open(FileSystem& files, const std::string& folder,
    const BlockedVolumeHeader& header, const StoreDescription& description,
    std::shared_ptr<SourceSamples> source = nullptr);

  std::uint64_t GetNumberOfBlocks() const { return this->Directory->GetCount(); }

  /// The ordinals of the blocks that an isosurface of one of the isovalues crosses, ascending.
  Result<std::vector<std::uint32_t>> FindActive(
    std::size_t variable, const std::vector<double>& isovalues, QueryStatistics& statistics);

  /// The ordinals of the blocks whose samples are all inside for one of the isovalues, ascending.
  /// Cost: a range query for all blocks with samples inside.
  Result<std::vector<std::uint32_t>> FindInside(
    std::size_t variable, const std::vector<double>& isovalues, QueryStatistics& statistics);

  /// The grid's index of a block.
  Result<std::int64_t> FindBlock(std::uint32_t ordinal, QueryStatistics& statistics) const;

  /// StoreRecords::Read of a block. Corrupt if another block has the ordinal.
  Result<DecodedBlocks> ReadAdjacent(std::uint32_t ordinal, std::int64_t block, std::size_t first,
    std::size_t count, int level, QueryStatistics& statistics) const;

  /// The range that ReadAdjacent reads; nothing if the directory's entry is damaged.
  std::optional<StoreRecords::ByteRange> FindAdjacent(
    std::uint32_t ordinal, std::size_t first, std::size_t count, int level) const;

  /// See StoreRecords.
  void Prefetch(const std::vector<StoreRecords::ByteRange>& ranges) const
  {
    this->Records->Prefetch(ranges);
  }

private:
  BlockStore(FileSystem& files, std::string folder, const BlockedVolumeHeader& header,
    const StoreDescription& description);
  Result<const ExternalIntervalTree*> GetTree(std::size_t variable);
  Result<BlockDirectoryEntry> FindEntry(std::uint32_t ordinal, QueryStatistics& statistics) const;

  FileSystem& Files;
  std::string Folder;
  StoreDescription Description;
  ArrayVariables Variables;
  BlockGrid Grid;
  std::unique_ptr<StoreRecords> Records;
  std::unique_ptr<BlockDirectory> Directory;
  std::mutex TreeMutex;
  std::vector<std::unique_ptr<ExternalIntervalTree>> Trees;
};

} // namespace isosurface

#endif
