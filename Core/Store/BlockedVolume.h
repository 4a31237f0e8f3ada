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
#include "Volume/BlockSelection.h"

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

/// Where a block stands: the Ordinal-th one of a store. Block is its index in the BlockGrid of the
/// levels that it has.
struct BlockReference
{
  std::int64_t Block = 0;
  std::uint32_t Store = 0;
  std::uint32_t Ordinal = 0;
  std::uint32_t Part = 0; ///< StoredLevel::Part

  bool operator==(const BlockReference& other) const
  {
    return this->Block == other.Block && this->Store == other.Store &&
      this->Ordinal == other.Ordinal && this->Part == other.Part;
  }
};

/**
 * Where a level of a volume is stored: in the records of the volume's own blocks, or in those of an
 * overview's, which are blocks of a coarser grid. Grid->GetVertices(block, Level) are the vertices
 * of such a block in the coordinates of the volume's level, that is, full ones / 2^level.
 */
struct StoredLevel
{
  std::uint32_t Part = 0;          ///< 0 is the volume itself, n the n-th overview
  int Level = 0;                   ///< of the records there
  const BlockGrid* Grid = nullptr; ///< the blocks there; belongs to the volume
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
  const BlockedVolumeHeader& GetHeader() const { return this->Parts.front()->Header; }
  /// What can be contoured and read, by number.
  const ArrayVariables& GetVariables() const { return this->Variables; }
  /// The volume's own blocks, which have its finest levels.
  const BlockGrid& GetBlockGrid() const { return this->Parts.front()->Grid; }
  /// Level l has every vertex whose coordinates are multiples of 2^l, whatever it is stored in.
  int GetNumberOfLevels() const;
  /// `level` must be one of the volume's.
  StoredLevel FindLevel(int level) const;

  /**
   * The blocks of this rank's share that an isosurface of one of the isovalues passes (some samples
   * are >= the isovalue, some are not), sorted by store and ordinal, each once; of the blocks that
   * have the given level (FindLevel). They are active at the finest level there,
   * GetSpectrumLevel(); at a coarser one some of them may turn out empty. Cost: one tree query a
   * store and isovalue, and the directory pages of the reported blocks.
   *
   * A selection adds blocks and leaves blocks out, before they are shared among ranks; it is of the
   * grid of `level`. It costs the directory pages of all blocks of the rank's stores that may be
   * selected; if sides are closed, a range query of the trees for all blocks with samples inside.
   */
  Result<std::vector<BlockReference>> FindActiveBlocks(std::size_t timeStep, std::size_t variable,
    const std::vector<double>& isovalues, int rank, int ranks, QueryStatistics& statistics,
    int level = 0, const BlockSelection& selection = {});

  /// This rank's share of all blocks that have a level, sorted by store and ordinal. Reads the
  /// directories of their stores.
  Result<std::vector<BlockReference>> GetShare(
    std::size_t timeStep, int rank, int ranks, QueryStatistics& statistics, int level = 0);

  /**
   * One variable of a block at a level, decoded, with its ghost layer; from the block cache or by
   * one read of the part of the block's record that holds the levels up to this one. The block must
   * be one that has the level. Coordinates are the level's. A magnitude is computed from the
   * components, which are read as by ReadVariables.
   */
  Result<std::shared_ptr<const DecodedBlock>> ReadBlock(const BlockReference& reference,
    std::size_t timeStep, std::size_t variable, int level, QueryStatistics& statistics);

  /**
   * Several variables of a block, in the order asked for. At the finest level of a block,
   * components that follow each other in the record and are not in the cache are read by one read.
   */
  Result<DecodedBlocks> ReadVariables(const BlockReference& reference, std::size_t timeStep,
    const std::vector<std::size_t>& variables, int level, QueryStatistics& statistics);

  /// Tells the block cache which blocks a query is going to read (BlockCache::Expect).
  void Expect(const std::vector<BlockReference>& blocks, std::size_t timeStep,
    const std::vector<std::size_t>& variables, int level);

  /// Whether a variable of a block is in the block cache, or on its way there.
  bool IsCached(
    const BlockReference& reference, std::size_t timeStep, std::size_t variable, int level) const;

  /**
   * Starts reading the blocks [begin, end) of a list for calls of ReadVariables that will follow
   * soon, without waiting for them: neighbors in a store as one. What is in the block cache is left
   * out. A hint, without errors: those are ReadVariables' own. Cost: the blocks' directory pages.
   */
  void Prefetch(const std::vector<BlockReference>& blocks, std::size_t begin, std::size_t end,
    std::size_t timeStep, const std::vector<std::size_t>& variables, int level);

  /// Memory for one variable of all blocks at a level, decoded, in bytes (ghost layers included).
  std::uint64_t EstimateBytes(std::size_t variable, int level) const;

  /// The finest level that is stored in the same blocks as this one. Its spectrum is stored too.
  int GetSpectrumLevel(int level) const;

  /// The spectrum of a variable's whole volume at GetSpectrumLevel(level), read from disk at the
  /// first call for a time step, then kept; and of each of the volume's own stores, at level 0,
  /// read at each call. All spectra of a variable have the same bins.
  Result<std::shared_ptr<const WorkloadSpectrum>> GetSpectrum(
    std::size_t timeStep, std::size_t variable, int level = 0);
  Result<std::shared_ptr<const WorkloadSpectrum>> GetStoreSpectrum(
    std::size_t timeStep, std::size_t variable, std::uint32_t store);

  /**
   * The triangles of an isosurface at a level: counted ones where the level has a spectrum and the
   * isovalue is one of its bins' edges; else a guess from the nearest spectra, between which the
   * logarithm of the count is taken to be linear in the level, and behind the last of which each
   * level has a quarter of the triangles of the one before.
   */
  Result<double> EstimateTriangles(
    std::size_t timeStep, std::size_t variable, double isovalue, int level);

private:
  BlockedVolume(std::string path, FileSystem& files, std::shared_ptr<BlockCache> cache,
    std::string text, BlockedVolumeHeader header);

  /// The volume itself, or an overview: what is needed to read its stores.
  struct Part
  {
    BlockedVolumeHeader Header;
    BlockGrid Grid;
    int FirstLevel = 0;                    ///< of the volume's levels, the finest one here
    std::vector<std::uint64_t> Identities; ///< per time step: Dataset of its BlockCacheKey
    std::vector<std::shared_ptr<const VolumeSpectra>> Spectra; ///< per time step
  };

  class BlockReading;
  struct OpenStore
  {
    std::size_t TimeStep;
    std::uint32_t Part;
    std::uint32_t Index;
    std::shared_ptr<BlockStore> Store;
  };

  void AddPart(BlockedVolumeHeader header);
  /// All blocks of a store that FindActiveBlocks finds with a selection, by ordinal.
  Result<std::vector<BlockReference>> SelectBlocks(BlockStore& store, std::uint32_t number,
    std::size_t variable, const std::vector<double>& isovalues, const BlockSelection& selection,
    int level, QueryStatistics& statistics);
  Result<std::shared_ptr<BlockStore>> GetStore(
    std::size_t timeStep, std::uint32_t part, std::uint32_t store);
  Result<std::shared_ptr<const VolumeSpectra>> GetSpectra(std::size_t timeStep, std::uint32_t part);
  /// Ok if the header on disk still names the time step as it was when this was opened.
  Status CheckNotRewritten(std::size_t timeStep) const;
  Status CheckArguments(std::size_t timeStep, std::size_t variable, int level) const;
  Status CheckRank(int rank, int ranks) const;
  BlockCacheKey MakeKey(std::int64_t block, std::size_t timeStep, std::size_t variable,
    const StoredLevel& stored) const;

  std::string Path;
  FileSystem& Files;
  std::shared_ptr<BlockCache> Cache;
  std::string HeaderText;
  ArrayVariables Variables;
  std::vector<std::unique_ptr<Part>> Parts; ///< the volume, then its overviews

  std::mutex Mutex;
  std::list<OpenStore> OpenStores; ///< the most recently used one first
};

} // namespace isosurface

#endif
