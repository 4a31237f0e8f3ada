// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolume_h
#define isosurface_BlockedVolume_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/VolumeOpener.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"
#include "Storage/Store/BlockCache.h"
#include "Storage/Store/QueryStatistics.h"
#include "Storage/Store/StoreFaults.h"
#include "Storage/Store/StoreSearch.h"
#include "Storage/Store/VolumeLayout.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

class BlockStore;
class VolumeStores;

/// The lost and damaged stores that the ranks have told each other; the same on all ranks.
struct StoreNews
{
  bool IsNew = false;  ///< whether a fault was not known before
  std::string Warning; ///< names the stores that no warning has named yet; may be empty
};

/**
 * A blocked volume on disk, opened for reading. Opening reads the header alone; the files of a
 * store are opened when they are first needed. All functions may be called by several threads at
 * once, each with statistics of its own, to which the cost is added.
 *
 * Where several stores have each block (BlockedVolumeHeader::NumberOfReplicas), a replica that is
 * lost or damaged is noticed when it is read, and another one is read instead, if this rank reaches
 * one; results are the same. Which rank reads which block is decided above (PlanQuery).
 *
 * Errors name file and reason: Corrupt, NotFound (a store is missing, or the volume was rewritten
 * since it was opened and must be opened anew), IoError.
 */
class BlockedVolume : public VolumeLayout
{
public:
  /// Reads and checks the header. `opener`: for the samples of a volume in place, which are
  /// Unsupported without it. `place`: what changes its grid. Cost: one file of a few KiB. A missing file
  /// is NotFound, a newer format version Unsupported, an impossible place InvalidArgument.
  static Result<std::shared_ptr<BlockedVolume>> Open(const std::string& path,
    FileSystem& fileSystem = GetLocalFileSystem(),
    std::shared_ptr<BlockCache> cache = BlockCache::GetProcessCache(),
    VolumeOpener opener = nullptr, const GridPlace& place = {});
  BlockedVolume(const BlockedVolume&) = delete;
  BlockedVolume& operator=(const BlockedVolume&) = delete;
  ~BlockedVolume();

  /// InvalidArgument unless the volume has the time step, the variable and the level.
  Status CheckArguments(std::size_t timeStep, std::size_t variable, int level) const;
  /// What follows the path in errors of a shortage of memory.
  static constexpr const char* NoMemoryReason = ": there is not enough memory to read it";

  /// ChooseReadingThreads() of where the samples of a time step are.
  int ChooseThreads(std::size_t timeStep, int threads) const;

  /// Whether a rank may reach no other stores than its own, else every rank reaches every store.
  /// Must be the same on all ranks. True at first.
  void SetLocalStores(bool areLocal) { this->AreStoresLocal = areLocal; }
  bool HasLocalStores() const { return this->AreStoresLocal; }

  /**
   * Finds the blocks of a store, or of a span of it, that an isosurface of one of the isovalues
   * crosses (some samples are >= the isovalue, some are not), by ordinal. They are those blocks
   * that have the given level (FindLevel), and active at the finest level there,
   * GetSpectrumLevel(); at a coarser one some may be empty. Cost: one tree query an isovalue, and
   * the directory pages of the reported blocks; QuerySeconds are for the caller to count. The store
   * must be one of those that have the level.
   *
   * A selection adds blocks and leaves blocks out before the store is divided into spans. Cost: the
   * directory pages of all candidate blocks of the store; if sides are closed, also a range query
   * of the tree for all blocks with samples inside.
   */
  Result<std::vector<BlockReference>> FindActiveBlocks(
    const BlockQuery& query, const StoreSpan& span, int level, QueryStatistics& statistics);

  /// All blocks that have a level, sorted by store and ordinal. Cost: the stores' directories.
  Result<std::vector<BlockReference>> ListBlocks(
    std::size_t timeStep, QueryStatistics& statistics, int level = 0);

  /// What isosurfaces take of each store that has a level (VolumeStores::FindStoreWork).
  Result<StoreWork> FindStoreWork(const BlockQuery& query, int level);
  const StoreFaults& GetFaults() const;

  /**
   * Tells all ranks which replicas of stores were found to be lost or damaged since the last call.
   * From then on the ranks share the blocks among the others. A query that failed on a rank may
   * succeed now if something is new: a rank whose stores are lost leaves their blocks to others.
   * Collective, unless there are no replicas. Error of all ranks: OutOfMemory.
   */
  Result<StoreNews> ShareStoreFaults(Communicator& ranks);
  /// Ok unless the time step's samples are in a file that is open, and was changed since it was
  /// indexed: the block cache has samples of the file as it was. Corrupt. Cost: a look at its files.
  Status CheckSource(std::size_t timeStep);
  /// Differs if ShareStoreFaults has learnt something: shares may be others then.
  std::uint64_t GetFaultEpoch() const { return this->FaultEpoch; }

  /**
   * Returns one variable of a block at a level, decoded, with its ghost layer, from the block cache
   * or by one read of the part of the block's record up to that level. The block must have the
   * level. Coordinates are the level's. A magnitude is computed from the components, which are read
   * as by ReadVariables.
   */
  Result<std::shared_ptr<const DecodedBlock>> ReadBlock(const BlockReference& reference,
    std::size_t timeStep, std::size_t variable, int level, QueryStatistics& statistics);

  /// Whether the samples of a variable at level 0 are in a source at an address, for ReadSource().
  bool IsAtAddress(std::size_t timeStep, std::size_t variable) const;
  /// Writes these samples in a box to `to`: x fastest, without gaps. Only the chunks that the box crosses are fetched,
  /// side by side; so no checksum of a block is compared.
  Status ReadSource(std::size_t timeStep, std::size_t variable, const VertexBox& box,
    std::uint8_t* to, QueryStatistics& statistics);

  /// Returns several variables of a block, in the given order. At level 0 of a record, components
  /// that follow each other in the record and are not in the cache are read by one read.
  Result<DecodedBlocks> ReadVariables(const BlockReference& reference, std::size_t timeStep,
    const std::vector<std::size_t>& variables, int level, QueryStatistics& statistics);

  /// Tells the block cache which blocks a query will read (BlockCache::Expect).
  void Expect(const std::vector<BlockReference>& blocks, std::size_t timeStep,
    const std::vector<std::size_t>& variables, int level);

  /// Whether a variable of a block is in the block cache, or on its way there.
  bool IsCached(
    const BlockReference& reference, std::size_t timeStep, std::size_t variable, int level) const;

  /// Starts reading the blocks [begin, end) of a list for calls of ReadVariables that follow soon,
  /// without waiting; neighbours in a store as one read. Skips what is in the block cache. This is
  /// a hint without errors: ReadVariables reports them. Cost: the blocks' directory pages.
  void Prefetch(const std::vector<BlockReference>& blocks, std::size_t begin, std::size_t end,
    std::size_t timeStep, const std::vector<std::size_t>& variables, int level);

  /// The bytes of one variable of all blocks at a level, decoded, with ghost layers.
  std::uint64_t EstimateBytes(std::size_t variable, int level) const;

  /// The spectrum of a variable in the whole volume at GetSpectrumLevel(level), read at the first
  /// call for a time step, then kept. All spectra of a variable have the same bins.
  Result<std::shared_ptr<const WorkloadSpectrum>> GetSpectrum(
    std::size_t timeStep, std::size_t variable, int level = 0);
  /// The same for one of the volume's own stores at level 0, read at each call.
  Result<std::shared_ptr<const WorkloadSpectrum>> GetStoreSpectrum(
    std::size_t timeStep, std::size_t variable, std::uint32_t store);

  /**
   * The triangles of an isosurface at a level: exact where the level has a spectrum and the
   * isovalue is an edge of its bins. Otherwise interpolated between the nearest spectra, the
   * logarithm of the count linearly in the level; beyond the last spectrum, each level has a
   * quarter of the triangles of the one before.
   */
  Result<double> EstimateTriangles(
    std::size_t timeStep, std::size_t variable, double isovalue, int level);

private:
  BlockedVolume(VolumeLayout layout, FileSystem& files, const std::shared_ptr<BlockCache>& cache,
    VolumeOpener opener);
  /// Of blocks in one replica of a store.
  void Prefetch(const BlockStore& store, const std::vector<const BlockReference*>& blocks,
    std::size_t timeStep, const std::vector<std::size_t>& variables, const StoredLevel& stored);

  std::shared_ptr<BlockCache> Cache;
  std::unique_ptr<VolumeStores> Stores;
  std::atomic<bool> AreStoresLocal{ true };
  std::atomic<std::uint64_t> FaultEpoch{ 0 };
};

} // namespace isosurface

#endif
