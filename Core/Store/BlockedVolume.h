// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolume_h
#define isosurface_BlockedVolume_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Partition/WorkloadSpectrum.h"
#include "Store/BlockCache.h"
#include "Store/BlockedVolumeHeader.h"
#include "Store/QueryStatistics.h"
#include "Volume/BlockGrid.h"

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace isosurface
{

class BlockStore;
class VolumeSpectra;

/// Where a block stands: the Ordinal-th one of a store. Block is its index in the BlockGrid.
struct BlockReference
{
  std::int64_t Block = 0;
  std::uint32_t Store = 0;
  std::uint32_t Ordinal = 0;

  bool operator==(const BlockReference& other) const
  {
    return this->Block == other.Block && this->Store == other.Store &&
      this->Ordinal == other.Ordinal;
  }
};

/**
 * A blocked volume on disk, opened for reading. Opening reads the header alone; the files of a
 * store are opened when they are first needed. All functions may be called by several threads at
 * once, each with statistics of its own, to which the cost is added.
 *
 * P ranks share D stores: with P <= D, rank r takes the stores d with d mod P == r; with P > D, the
 * ranks r with r mod D == d share store d, each taking a contiguous part of the blocks asked for in
 * the order of their ordinals. No rank needs another one for that.
 *
 * Errors name file and reason: Corrupt, NotFound (a store that is missing; a dataset that was
 * rewritten since it was opened, which must be opened anew), IoError.
 */
class BlockedVolume
{
public:
  /// Reads and checks the header. Cost: one file of a few KiB. A missing file is NotFound, a newer
  /// format version Unsupported.
  static Result<std::shared_ptr<BlockedVolume>> Open(const std::string& path,
    FileSystem& fileSystem = GetLocalFileSystem(),
    std::shared_ptr<BlockCache> cache = BlockCache::GetProcessCache());
  BlockedVolume(const BlockedVolume&) = delete;
  BlockedVolume& operator=(const BlockedVolume&) = delete;
  ~BlockedVolume();

  const std::string& GetPath() const { return this->Path; }
  const BlockedVolumeHeader& GetHeader() const { return this->Header; }
  const BlockGrid& GetBlockGrid() const { return this->Grid; }
  int GetNumberOfLevels() const { return this->Grid.GetNumberOfLevels(); }

  /**
   * The blocks of this rank's share that an isosurface of one of the isovalues passes (some samples
   * are >= the isovalue, some are not), sorted by store and ordinal, each once. The blocks are
   * active at full resolution; at a coarser level some of them may turn out empty.
   * Cost: one tree query a store and isovalue, and the directory pages of the reported blocks.
   */
  Result<std::vector<BlockReference>> FindActiveBlocks(std::size_t timeStep, std::size_t array,
    const std::vector<double>& isovalues, int rank, int ranks, QueryStatistics& statistics);

  /// This rank's share of all blocks, sorted by store and ordinal. Reads the stores' directories.
  Result<std::vector<BlockReference>> GetShare(
    std::size_t timeStep, int rank, int ranks, QueryStatistics& statistics);

  /**
   * One array of a block at a level, decoded, with its ghost layer; from the block cache or by one
   * read of the part of the block's record that holds the levels up to this one.
   */
  Result<std::shared_ptr<const DecodedBlock>> ReadBlock(const BlockReference& reference,
    std::size_t timeStep, std::size_t array, int level, QueryStatistics& statistics);

  /// Memory for one array of all blocks at a level, decoded, in bytes (ghost layers included).
  std::uint64_t EstimateBytes(std::size_t array, int level) const;

  /// The spectrum of an array's whole volume, read from disk at the first call for a time step,
  /// then kept; and of a store, read at each call. (Volumes of older versions have triangles and
  /// cells only.)
  Result<std::shared_ptr<const WorkloadSpectrum>> GetSpectrum(
    std::size_t timeStep, std::size_t array);
  Result<std::shared_ptr<const WorkloadSpectrum>> GetStoreSpectrum(
    std::size_t timeStep, std::size_t array, std::uint32_t store);

private:
  BlockedVolume(std::string path, FileSystem& files, std::shared_ptr<BlockCache> cache,
    std::string text, BlockedVolumeHeader header);

  struct OpenStore
  {
    std::size_t TimeStep;
    std::uint32_t Index;
    std::shared_ptr<BlockStore> Store;
  };

  Result<std::shared_ptr<BlockStore>> GetStore(std::size_t timeStep, std::uint32_t store);
  Result<std::shared_ptr<const VolumeSpectra>> GetSpectra(std::size_t timeStep);
  /// Ok if the header on disk still names the time step as it was when this was opened.
  Status CheckNotRewritten(std::size_t timeStep) const;
  Status CheckArguments(std::size_t timeStep, std::size_t array) const;
  Status CheckRank(int rank, int ranks) const;

  std::string Path;
  FileSystem& Files;
  std::shared_ptr<BlockCache> Cache;
  std::string HeaderText;
  BlockedVolumeHeader Header;
  BlockGrid Grid;
  std::vector<std::uint64_t> Identities; ///< per time step: Dataset of its BlockCacheKey

  std::mutex Mutex;
  std::list<OpenStore> OpenStores; ///< the most recently used one first
  std::vector<std::shared_ptr<const VolumeSpectra>> Spectra;
};

} // namespace isosurface

#endif
