// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WrittenStores_h
#define isosurface_WrittenStores_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BlockGrid.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Writing/BlockCounts.h"
#include "Storage/Writing/BlockExchange.h"
#include "Storage/Writing/BlockStoreWriter.h"
#include "Storage/Writing/StoreJournal.h"
#include "Storage/Writing/WriteContext.h"
#include "Storage/Writing/WriteJournal.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// Copies a finished store of the last time step of `header`, which may be that of an overview, to
/// the folders of other stores, as many as it has replicas there, and brings the copies to stable
/// storage. `path`: that of the volume. Cost: one pass over the store's files for each replica.
/// Memory: a MiB.
Status ReplicateStore(FileSystem& files, const std::string& path, const BlockedVolumeHeader& header,
  std::uint32_t store);

/// The stores of a grid that this rank writes, with the samples that they leave for a coarser grid and
/// with their journals. Nothing of it is collective.
class WrittenStores
{
public:
  /// The segments of a record.
  static std::size_t CountSegments(const BlockedVolumeHeader& header);

  /// `header`: of the grid; its last time step is written, and has its folder. `blockStores`: the store
  /// of each block. The references must outlive this object.
  WrittenStores(const WriteContext& context, const BlockedVolumeHeader& header,
    const std::vector<std::uint32_t>& blockStores, bool hasCoarser, bool hasJournal);

  /// Makes empty ones.
  Status Create();
  /// Opens those of an earlier write as its journal says, and adds what that has counted. Corrupt if
  /// they are not of this one.
  Status Take(const WriteJournal& journal, BlockCounts& counts);

  /// Appends a finished block to its store. Blocks come in the order of their numbers.
  Status Append(const PendingBlock& block);
  /// Brings all that is known of the blocks to stable storage, as a checkpoint of this number.
  Status AddCheckpoints(std::int64_t number, const BlockCounts& counts) const;
  std::vector<std::uint32_t> GetNumbers() const;
  /// Adds the records of the blocks [begin, end), which are appended, to `records`, by the folders of
  /// their stores.
  void FindRecords(std::int64_t begin, std::int64_t end,
    std::map<std::string, std::vector<BlockDirectoryEntry>>& records) const;
  /// Finishes a store, for which it takes `memoryBytes` at most, and its spectra. Different stores may
  /// be finished at once. Corrupt if the disk gave back other bytes than it was given.
  Result<StoreDescription> Finish(
    std::uint32_t number, BlockCounts& counts, std::size_t memoryBytes);
  /// Removes the samples for a coarser grid, and the journals.
  Status RemoveTemporaryFiles() const;

private:
  struct OpenStore
  {
    std::unique_ptr<BlockStoreWriter> Writer;
    std::unique_ptr<WritableFile> OverviewSamples; ///< null without a coarser grid
    AppendedSum OverviewSum;
    std::unique_ptr<StoreJournal> Journal; ///< null without a journal
  };

  Status TakeOne(
    std::uint32_t store, std::size_t blocks, std::int64_t checkpoint, BlockCounts& counts);
  Status TakeOverviewSamples(std::uint32_t store, const std::vector<BlockDirectoryEntry>& entries,
    const StoreCheckpoint& checkpoint);
  /// How many blocks before `end` each store has.
  std::vector<std::size_t> CountBlocks(std::int64_t end) const;
  SamplePlace GetSamplePlace() const
  {
    return this->Header.IsInPlace() ? SamplePlace::Source : SamplePlace::Store;
  }
  std::string GetFolder() const
  {
    return GetStoresFolder(this->Context.Files, this->Context.Path) + "/" +
      this->Header.TimeSteps.back().Folder;
  }
  std::string GetStorePath(std::uint32_t store) const
  {
    return GetStoreFolder(
      this->Context.Files, this->Context.Path, this->Header.TimeSteps.back().Folder, store);
  }

  const WriteContext& Context;
  const BlockedVolumeHeader& Header;
  const std::vector<std::uint32_t>& BlockStores;
  const bool HasCoarser;
  const bool HasJournal;
  const BlockGrid Grid;
  const ArrayVariables Variables;
  const std::size_t Segments;
  std::map<std::uint32_t, OpenStore> Stores;
};

} // namespace isosurface

#endif
