// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolumeWriter_h
#define isosurface_BlockedVolumeWriter_h

#include "Base/Communicator.h"
#include "Base/FileSystem.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Partition/BlockDistribution.h"
#include "Store/BlockCompression.h"
#include "Store/BlockedVolumeHeader.h"
#include "Volume/GridGeometry.h"
#include "Volume/SampleView.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * The part of a volume that one rank has in memory: the vertices of Box (counted from 0 at the
 * grid's first vertex), one view an array, each with Box within its Available. Box may be empty.
 */
struct VolumePiece
{
  VertexBox Box;
  std::vector<SampleView> Arrays;
};

/// What the user of a writer chooses; equal on all ranks.
struct BlockedVolumeSettings
{
  int BlockSize = 32;               ///< cells a side: 16, 32 or 64
  std::uint32_t NumberOfStores = 0; ///< 0: as many as there are ranks
  DistributionMethod Distribution = DistributionMethod::Greedy;
  std::uint64_t RandomSeed = 0;
  BlockCompression Compression;
  std::optional<double> Time;                  ///< the time of the one time step
  std::uint64_t RoundBytes = 64 * 1024 * 1024; ///< samples that travel in a round, all ranks
  std::uint64_t IndexBytes = 64 * 1024 * 1024; ///< a rank's memory for sorting intervals
  int Threads = 0;                             ///< 0: this rank's share of the node's cores
};

/// What was written; equal on all ranks.
struct WriteStatistics
{
  std::uint64_t Blocks = 0;
  std::uint64_t Bytes = 0;             ///< of blocks, all stores
  std::uint64_t Rounds = 0;            ///< of exchange between the ranks
  std::uint64_t LargestRoundBytes = 0; ///< samples in the largest round, all ranks
  std::vector<StoreDescription> Stores;
};

/**
 * Writes a volume, held in pieces by the ranks of a group, as a blocked volume: blocks with ghost
 * layers and levels, spread over stores, and an external interval tree a store and array.
 *
 * Collective: every rank calls Write with equal arguments but for its piece. The pieces may overlap
 * in any way; together they must cover the grid. The stores d with d mod P == r are written by rank
 * r of P, on a file system that all ranks see. Every array has its own tree; the first array's
 * value ranges decide which store a block goes to. The files are byte for byte the same for
 * any number of ranks and threads.
 *
 * Whatever fails on any rank, or whichever rank's progress asks to stop: all ranks return an error,
 * and what was at `path` before is untouched. The new dataset becomes visible by one rename at the
 * end; then the folders of older ones that no header names are removed.
 *
 * Cost: one pass over the samples for ranges, one for writing. Memory beyond the piece: 16 bytes a
 * block and array, about 60 a block that this rank writes, up to 3 RoundBytes, IndexBytes.
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

  Result<WriteStatistics> Write(const std::string& path, const GridGeometry& grid,
    const std::vector<ArrayDescription>& arrays, const VolumePiece& piece,
    const BlockedVolumeSettings& settings, const Progress& progress = {});

private:
  Communicator& Ranks;
  FileSystem& Files;
};

} // namespace isosurface

#endif
