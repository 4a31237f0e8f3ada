// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FinishedLayers_h
#define isosurface_FinishedLayers_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"
#include "Ground/Volume/ValueKey.h"
#include "Ground/Volume/VolumeOpener.h"
#include "Storage/Store/BlockCache.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/SourceSamples.h"
#include "Storage/Store/StoreSearch.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * The layers of blocks of a volume in place that are written, from the first one on, while others
 * are not: what is known of them, so that surfaces can be extracted there. Samples are read from the
 * source through the block cache, as those of the finished volume are; so surfaces are the same.
 *
 * The writer's thread calls Begin, Add and End. All functions may be called by several threads at
 * once. Memory: the value ranges of the blocks.
 */
class FinishedLayers
{
public:
  /// `path`: of the volume. `files` must outlive this object.
  FinishedLayers(FileSystem& files, VolumeOpener opener, std::string path);
  FinishedLayers(const FinishedLayers&) = delete;
  FinishedLayers& operator=(const FinishedLayers&) = delete;
  ~FinishedLayers();

  /// The volume, with a time step in place, before its first block is added.
  void Begin(BlockedVolumeHeader header);
  /// The next blocks are finished. ranges[variable][n] is that of the n-th of them.
  void Add(const std::vector<std::vector<KeyRange>>& ranges);
  /// Nothing is added any more.
  void End() { this->IsEnded = true; }

  bool HasEnded() const { return this->IsEnded; }
  /// Tells that they are shown, as long as what is returned exists.
  std::shared_ptr<const void> Show();
  bool AreShown() const;
  /// How many slices of cells have all of their blocks.
  std::int64_t CountSlices() const;
  /// The volume; known as soon as there are slices.
  const BlockedVolumeHeader& GetHeader() const { return this->Header; }
  /// The blocks of the first slices that a surface needs, with arrays to interpolate: part `part` of
  /// `parts` of them, which have equally many. The source must not outlive this object. Errors: those
  /// of SourceSamples::Open.
  Result<std::unique_ptr<BlockSource>> FindBlocks(const BlockQuery& query,
    const std::vector<std::size_t>& attributes, std::int64_t slices, std::size_t part,
    std::size_t parts);

private:
  class Blocks;

  Status OpenSamples();

  FileSystem& Files;
  const VolumeOpener Opener;
  const std::string Path;
  const std::shared_ptr<BlockCache> Cache;
  const std::uint64_t Dataset; ///< BlockCacheKey::Dataset
  BlockedVolumeHeader Header;
  BlockGrid Grid;
  std::atomic<bool> IsEnded = false;
  std::mutex OpeningMutex;                ///< guards Samples, whose opening nobody else waits for
  std::shared_ptr<SourceSamples> Samples; ///< null until blocks are asked for
  mutable std::mutex Mutex;               ///< guards what follows
  std::vector<std::vector<KeyRange>> Ranges;
  std::weak_ptr<const void> Shown;
};

} // namespace isosurface

#endif
