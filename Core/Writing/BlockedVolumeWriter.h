// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolumeWriter_h
#define isosurface_BlockedVolumeWriter_h

#include "Base/Communicator.h"
#include "Base/FileSystem.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Partition/BlockDistribution.h"
#include "Record/BlockCompression.h"
#include "Source/MemorySource.h"
#include "Source/SlabSource.h"
#include "Store/BlockedVolumeHeader.h"
#include "Volume/GridGeometry.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// What the user of a writer chooses; equal on all ranks.
struct BlockedVolumeSettings
{
  int BlockSize = 32;               ///< cells a side: 16, 32 or 64
  std::uint32_t NumberOfStores = 0; ///< 0: as many as there are ranks
  DistributionMethod Distribution = DistributionMethod::Greedy;
  std::uint64_t RandomSeed = 0;
  BlockCompression Compression;
  std::optional<double> Time; ///< the time of the time step
  /// Adds the time step to the volume at the path, behind those that it has. They must have the
  /// same grid, arrays, block size, stores (0: as many as they have), distribution and compression,
  /// and an earlier time; else this is an InvalidArgument. A volume that is not there is begun.
  bool Append = false;
  /// Whether the time step is visible at the end. If not, it becomes so with the next one that the
  /// same writer appends and publishes, all in one step.
  bool Publish = true;
  /// Bytes that a rank may hold beside what its source had in memory before.
  std::uint64_t MemoryLimit = std::uint64_t{ 1 } << 30;
  int Threads = 0; ///< 0: this rank's share of the node's cores
};

/// What was written; equal on all ranks.
struct WriteStatistics
{
  std::uint64_t Blocks = 0;
  std::uint64_t Bytes = 0;         ///< of blocks, all stores
  std::uint64_t OverviewBytes = 0; ///< of the blocks of all overviews
  std::uint64_t Rounds = 0;        ///< of reading, exchange and writing
  std::uint64_t MemoryBytes = 0;   ///< of a rank, as planned; within the limit
  std::vector<StoreDescription> Stores;
};

/**
 * Writes a volume as a blocked volume: blocks with ghost layers and levels, spread over stores, and
 * an external interval tree a store and array. The volume may be larger than the memory of all
 * ranks: it is read from each rank's source in slabs.
 *
 * Collective: every rank calls Write with equal arguments but for its source. The sources' boxes
 * may overlap in any way; together they must cover the grid. If every rank's source has the whole
 * grid (a file that all see), each reads its share and nothing but finished records travels;
 * otherwise the ranks supply each other with what their parts lack. The stores d with d mod P == r
 * are written by rank r of P, on a file system that all ranks see. Every array has its own tree;
 * the first array's value ranges decide which store a block goes to. The files are byte for byte
 * the same for any number of ranks and threads, and any memory limit.
 *
 * Whatever fails on any rank, or whichever rank's progress asks to stop: all ranks return an error,
 * and what was at `path` before is untouched. The new dataset becomes visible by one rename at the
 * end; then the folders of older ones that no header names are removed. A killed run leaves a
 * folder that no header names, which the next write to the path removes before it begins. While one
 * writer is at work, another one to the same path fails at once.
 *
 * Appending a time step touches no file of the steps before but for the header, which is written
 * anew with about 80 bytes for each store and step. Steps that are not published yet are removed
 * when a later one fails, or with the writer.
 *
 * Cost: two passes over the samples: one for the blocks' value ranges, from which the distribution
 * follows, one for writing, which reads up to ten slices a layer of blocks once more for the ghost
 * layers of coarser levels. Memory: within MemoryLimit; InvalidArgument if that does not suffice
 * for a block a rank and about 100 bytes for every block of the volume.
 *
 * Source: X. Zhang, C. Bajaj, "Scalable isosurface visualization of massive datasets on commodity
 * off-the-shelf clusters", 2009, sections 4.1.1 (preprocessing steps 1 to 3).
 */
class BlockedVolumeWriter
{
public:
  explicit BlockedVolumeWriter(
    Communicator& communicator, FileSystem& fileSystem = GetLocalFileSystem())
    : Ranks(communicator)
    , Files(fileSystem)
  {
  }
  BlockedVolumeWriter(const BlockedVolumeWriter&) = delete;
  BlockedVolumeWriter& operator=(const BlockedVolumeWriter&) = delete;
  ~BlockedVolumeWriter();

  Result<WriteStatistics> Write(const std::string& path, const GridGeometry& grid,
    const std::vector<ArrayDescription>& arrays, SlabSource& source,
    const BlockedVolumeSettings& settings, const Progress& progress = {});

  /// The same for a piece that is in memory: a view a component, array after array.
  Result<WriteStatistics> Write(const std::string& path, const GridGeometry& grid,
    const std::vector<ArrayDescription>& arrays, const VolumePiece& piece,
    const BlockedVolumeSettings& settings, const Progress& progress = {});

private:
  void DiscardPending();

  Communicator& Ranks;
  FileSystem& Files;
  std::string PendingPath;
  std::optional<BlockedVolumeHeader> Pending; ///< with time steps that are not published yet
  std::unique_ptr<FolderLock> PendingLock;    ///< keeps other writers out meanwhile, on rank 0
};

} // namespace isosurface

#endif
