// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContourBlocks_h
#define isosurface_ContourBlocks_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/ValueKey.h"
#include "Ranks/Query/SurfaceRequest.h"
#include "Surface/Contour/InterpolatedArray.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

class BlockedVolume;
struct MemoryQuery;

/**
 * The active blocks of a contour on one rank, for a consumer that takes a surface piece by piece.
 * Blocks are read when the consumer takes them, so it needs memory for those that it holds at once.
 */
struct ContourBlocks
{
  /// What is contoured, of all ranks: set by the caller. Normals: whether Source is to give samples for gradients.
  SurfaceRequest Request;
  GridGeometry Grid;  ///< of the level; GlobalIds number its vertices
  int Level = 0;      ///< of a blocked volume
  int BlockSize = 64; ///< cells along the side of a block, at the level; a power of two
  /// Whether this rank has samples. If not, it does not know Time, ArrayName and Arrays.
  bool HasSamples = false;
  std::string ArrayName;      ///< of the contoured array
  std::string Origin;         ///< where the samples came from, for people
  std::optional<double> Time; ///< of the samples
  KeyRange FiniteRange;       ///< of the contoured values, of blocks that are not active too

  std::vector<InterpolatedArray> Arrays; ///< to interpolate, in the order of Source's attributes

  /// This rank's active blocks, and those of BlockSelection. Owner keeps the samples that Source refers to.
  std::unique_ptr<BlockSource> Source;
  /// Numbers of these blocks, ascending: of all blocks of the grid, whichever rank has them. They
  /// are the same for any number of ranks.
  std::vector<std::int64_t> Numbers;
  std::shared_ptr<const void> Owner;
  std::shared_ptr<BlockedVolume> Volume; ///< that has the blocks; null if images have them
};

/// The active blocks of the query's share of a level. Fills in what follows from them; Request,
/// ArrayName and Arrays are there. Not collective.
Status CollectVolumeBlocks(const std::shared_ptr<BlockedVolume>& volume, const SurfaceQuery& query,
  int level, ContourBlocks& blocks);

/// The same of grids of which all ranks have pieces; Arrays are those of the pieces' attributes.
/// Collective.
Status CollectImageBlocks(Communicator& ranks, MemoryQuery query, ContourBlocks& blocks);

/// How blocks are encoded.
struct BlockCoding
{
  EdgeIndexSettings Settings;
  int PreviewLevel = 0;   ///< at most that of the blocks
  double ArrayError = 0;  ///< the maximum error of a value of an array
  double NormalError = 0; ///< and of a component of a normal
};

/// What an edge-index stream says of the blocks of all ranks: what the first rank that has samples knows of them,
/// and with Request.Islands the islands that it leaves out, after an extraction of the whole surface. Collective.
/// Errors of any rank: InvalidArgument (see EdgeIndexHeader::Check), OutOfMemory, those of ExtractSurface and
/// ChooseIslands.
Result<EdgeIndexHeader> MakeSurfaceHeader(Communicator& ranks, const ContourBlocks& blocks,
  const BlockCoding& coding, int threads, const Progress& progress);

/// Writes the blocks as an edge-index file. Collective. Errors: those of MakeSurfaceHeader and EdgeIndexWriteJob.
Result<EdgeIndexFileSummary> WriteBlocks(Communicator& ranks, const ContourBlocks& blocks,
  const BlockCoding& coding, const std::string& path, const EdgeIndexWriteJob::Settings& settings,
  const Progress& progress);

/// The interpolated arrays, which ranks without samples do not know. Collective. Error of any rank:
/// OutOfMemory.
Result<std::vector<InterpolatedArray>> ShareArrays(
  Communicator& ranks, const ContourBlocks& blocks);

} // namespace isosurface

#endif
