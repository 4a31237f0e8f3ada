// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolumeWriter_h
#define isosurface_BlockedVolumeWriter_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/MemorySource.h"
#include "Storage/Distribution/BlockDistribution.h"
#include "Storage/Record/BlockCompression.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/FinishedBlocks.h"
#include "Storage/Store/SourceRecord.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// The settings of a write; equal on all ranks.
struct BlockedVolumeSettings
{
  int BlockSize = 32;               ///< cells a side: 16, 32 or 64
  std::uint32_t NumberOfStores = 0; ///< 0: as many as there are ranks
  /// The number of stores that have each block, at most as many as there are; 0: those of the
  /// volume that is appended to, else 1.
  std::uint32_t NumberOfReplicas = 0;
  DistributionMethod Distribution = DistributionMethod::Greedy;
  std::uint64_t RandomSeed = 0;
  BlockCompression Compression;
  std::optional<double> Time; ///< the time of the time step
  /// Where the vertices of a rectilinear grid are; then origin, spacing and direction of the grid
  /// have no meaning.
  std::optional<GridLines> Lines;
  /// Appends the time step to the volume at the path; without one, makes a new volume. The volume
  /// must have the same grid, arrays, block size, stores and replicas (0: as many as it has),
  /// distribution and compression, and earlier times; else this is an InvalidArgument.
  bool Append = false;
  /// Writes no samples at level 0: they stay in this source (DescribeSource), which the writer's
  /// own source has to agree with. All time steps of a volume have one, or none has.
  std::optional<SourceRecord> InPlace;
  /// Of a volume that is not in place: what its samples are copied from, to be kept in the header.
  std::optional<SourceRecord> CopyOf;
  /// What the samples are read from, if these are files. It is an error of all ranks if they see
  /// different ones, or if one has changed by the end of the write.
  SourceFiles Files;
  /// Whether the time step is visible at the end. If not, it becomes visible together with the next
  /// one that the same writer appends and publishes.
  bool Publish = true;
  /// Keeps what is written if the write ends before all is, even if the program is killed: with at
  /// least JournalSeconds between two checkpoints (0: after each round). The next write of the same
  /// volume, from the same source, goes on there, with any number of ranks; it keeps the stores,
  /// unless the settings name a number. Only with InPlace or CopyOf, on file systems with locks.
  std::optional<double> JournalSeconds;
  /// Within so many seconds between checkpoints, a write need not wait for the disk.
  static constexpr double UsualJournalSeconds = 10;
  /// Called on the first rank, before anything is written, if the disk has not the room that the
  /// samples take uncompressed.
  std::function<void(const std::string& warning)> Warn;
  /// Called with what a rank reads of the volume, by the thread that reads.
  std::function<void(const BoxSamples& slab, const VertexBox& box)> WhenRead;
  /// Called on each rank by its writing thread: the next blocks of the volume are finished, and can be
  /// read (FinishedLayers). Unless the volume is in place, each round waits until it is written.
  std::function<void(const BlockedVolumeHeader& volume, FinishedBlocks blocks)> WhenFinished;
  /// Bytes that a rank may take, besides those that its source had in memory before.
  std::uint64_t MemoryLimit = std::uint64_t{ 1 } << 30;
  int Threads = 0; ///< 0: this rank's share of the node's cores
};

/// The result of a write; equal on all ranks.
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
 * Writes a blocked volume, or appends a time step to one. The volume may be larger than the memory
 * of all ranks: each rank reads slabs from its own source. The sources' boxes may overlap; together
 * they must cover the grid. For a given number of stores, the files depend neither on the number of
 * ranks and threads nor on the memory limit. Rank r of P writes the stores d with d mod P == r, on a
 * file system that all ranks share. Documentation/architecture/storage.md describes writing,
 * Documentation/formats the files.
 *
 * The rank that writes a store copies it to the folders of the stores that have replicas of it: so
 * replicas cost reading the store's files once more, and writing them, for each.
 *
 * On an error of any rank, or if any rank's progress asks to stop, all ranks return an error, and
 * the volume at `path` stays as it was. Another writer to the same path fails at once. With
 * JournalSeconds what was written remains beside it, for the next one.
 *
 * Cost: one pass over the samples; one more before it, for the blocks' value ranges, if these decide
 * where blocks are stored (Greedy and Balanced, with several stores). Memory: within MemoryLimit;
 * InvalidArgument if that does not suffice for a block on each rank and about 100 bytes for every
 * block of the volume. Source: X. Zhang, C. Bajaj, "Scalable isosurface visualization of massive
 * datasets on commodity off-the-shelf clusters", 2009, section 4.1.1.
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

  /// Collective. All arguments but the source and the progress are equal on all ranks. Steps that
  /// were not published are removed when a later one fails, or with the writer.
  Result<WriteStatistics> Write(const std::string& path, const GridGeometry& grid,
    const std::vector<ArrayDescription>& arrays, BoxSource& source,
    const BlockedVolumeSettings& settings, const Progress& progress = {});

  /// The same for a piece in memory: a view for each component, array after array.
  Result<WriteStatistics> Write(const std::string& path, const GridGeometry& grid,
    const std::vector<ArrayDescription>& arrays, const VolumePiece& piece,
    const BlockedVolumeSettings& settings, const Progress& progress = {});

private:
  void DiscardPending();

  Communicator& Ranks;
  FileSystem& Files;
  std::string PendingPath;
  std::optional<BlockedVolumeHeader> Pending; ///< with time steps that are not published yet
  bool IsPendingKept = false;                 ///< on disk, by a journal
  std::unique_ptr<PathLock> PendingLock;      ///< keeps other writers out meanwhile, on rank 0
};

} // namespace isosurface

#endif
