// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FinishedLayers_h
#define isosurface_FinishedLayers_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"
#include "Ground/Volume/GridPlace.h"
#include "Ground/Volume/Sight.h"
#include "Ground/Volume/ValueKey.h"
#include "Ground/Volume/VolumeOpener.h"
#include "Storage/Record/DecodedBlock.h"
#include "Storage/Store/BlockCache.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/FinishedBlocks.h"
#include "Storage/Store/SourceSamples.h"
#include "Storage/Store/StoreSearch.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * The layers of blocks of a volume that are written, from the first one on, while others are not: what
 * is known of them, so that surfaces can be extracted there. Samples are those of the finished volume,
 * so surfaces are the same: of a volume in place they come from the source, through the block cache;
 * else from the records that this rank has written.
 *
 * Of a volume in place, any box can be had before its layer is finished: its chunks are read then.
 *
 * The writer's thread calls Add and End. All functions may be called by several threads at
 * once. Memory: the value ranges of the blocks, and the directories of records.
 */
class FinishedLayers
{
public:
  /// `path`: of the volume. `files` must outlive this object. `place`: what changes the grid that is
  /// written. `mayRead`: whether boxes may be had; null: always.
  FinishedLayers(FileSystem& files, VolumeOpener opener, std::string path,
    const GridPlace& place = {}, std::function<bool()> mayRead = {});
  /// The volume in place as it is planned, before the first blocks.
  void Begin(const BlockedVolumeHeader& planned);
  /// The next blocks of the first time step of a volume.
  void Add(const BlockedVolumeHeader& volume, FinishedBlocks blocks);
  /// Nothing is added any more.
  void End() { this->IsEnded = true; }

  bool HasEnded() const { return this->IsEnded; }
  /// Tells how many surfaces more show them.
  void CountShown(int surfaces) { this->Shown += surfaces; }
  bool AreShown() const { return this->Shown > 0; }
  /// How many slices of cells have all of their blocks.
  std::int64_t CountSlices() const;
  /// The volume; known as soon as there are slices, or boxes can be had.
  const BlockedVolumeHeader& GetHeader() const { return this->Header; }
  /// Blocks of the first slices that a surface needs, with arrays to interpolate. Of a volume in place:
  /// part `part` of `parts`, which have equally many; else those whose records this rank has written. The
  /// source must not outlive this object. Errors: those of SourceSamples::Open, and of reading files.
  Result<std::unique_ptr<BlockSource>> FindBlocks(const BlockQuery& query,
    const std::vector<std::size_t>& attributes, std::int64_t slices, std::size_t part,
    std::size_t parts);

  ///@{
  /// What a person looks at, if that was told.
  void LookAlong(const Sight& sight);
  std::optional<Sight> GetSight() const;
  ///@}
  /// Whether boxes can be had.
  bool HasBoxes() const
  {
    return this->HasBegun && !this->IsEnded && this->Header.IsInPlace() && this->MayRead();
  }
  /// Whether reading a box may go on.
  bool MayRead() const { return !this->MayReadBoxes || this->MayReadBoxes(); }
  /// The same as FindBlocks, of the blocks in a box of vertices, which are cut there: all whose ranges are not known
  /// yet may have a surface. Their chunks are read by several threads before it returns, those of the box alone.
  /// Meanwhile WaitForBoxes() waits.
  Result<std::unique_ptr<BlockSource>> FindBox(const BlockQuery& query,
    const std::vector<std::size_t>& attributes, const VertexBox& box, std::size_t part,
    std::size_t parts, int threads);

  /// For the writer, whose threads read what is less urgent.
  void WaitForBoxes() const;

private:
  class Blocks;
  /// Reads the components [first, first + count) of a block.
  using ReadComponents =
    std::function<Result<DecodedBlocks>(std::int64_t block, std::size_t first, std::size_t count)>;

  Status OpenSamples();
  /// The blocks of the first slices that a surface needs.
  std::vector<std::int64_t> SelectBlocks(const BlockQuery& query, std::int64_t slices) const;
  /// The blocks with cells in a box that a surface may need.
  std::vector<std::int64_t> SelectBlocksIn(const BlockQuery& query, const VertexBox& box) const;
  /// Reads from the source, which is open. `part`: SourceSamples::ReadBlock.
  Result<DecodedBlocks> Gather(std::int64_t block, std::size_t first, std::size_t count,
    const VertexBox* part = nullptr) const;
  /// Keeps only those blocks whose records this rank has written, and opens their files.
  Result<ReadComponents> OpenRecords(std::vector<std::int64_t>& blocks) const;

  FileSystem& Files;
  const VolumeOpener Opener;
  const std::string Path;
  const GridPlace Place;
  const std::function<bool()> MayReadBoxes;
  BlockedVolumeHeader Header;
  BlockGrid Grid;
  std::atomic<bool> HasBegun = false;
  std::atomic<bool> IsEnded = false;
  std::atomic<int> Shown = 0;             ///< surfaces
  std::atomic<int> ReadBoxes = 0;         ///< that are being read
  std::mutex OpeningMutex;                ///< guards Samples while the source is being opened
  std::shared_ptr<SourceSamples> Samples; ///< null until blocks are asked for
  mutable std::mutex Mutex;               ///< guards what follows
  std::optional<Sight> Sighted;
  std::vector<std::vector<KeyRange>> Ranges;
  /// By the folders of their stores, in the order of their blocks.
  std::map<std::string, std::vector<BlockDirectoryEntry>> Records;
};

} // namespace isosurface

#endif
