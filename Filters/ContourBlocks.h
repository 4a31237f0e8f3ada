// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContourBlocks_h
#define isosurface_ContourBlocks_h

#include "Base/Communicator.h"
#include "Base/Status.h"
#include "SurfacePolyData.h"
#include "Volume/BlockSource.h"
#include "Volume/GridGeometry.h"
#include "Volume/Region.h"
#include "Volume/ValueKey.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

class BlockedVolume;
class ChosenScalars;
struct ImagePieces;
struct PieceAttributes;

/**
 * What a vtkStabbingContour contours on one rank, block by block: all that a consumer needs that
 * takes a surface piece by piece. Blocks are read when they are asked for, so such a consumer needs
 * memory for as many as it has at once.
 */
struct ContourBlocks
{
  GridGeometry Grid;  ///< of the level; its vertices are what GlobalIds count
  int Level = 0;      ///< of a blocked volume
  int BlockSize = 64; ///< cells along the side of a block, at the level; a power of two
  std::vector<double> Isovalues;
  /// Whether this rank has samples. If not, it does not know Time, ArrayName and Arrays.
  bool HasSamples = false;
  std::string ArrayName;      ///< of the contoured array
  std::string Origin;         ///< where the samples came from, for people
  std::optional<double> Time; ///< of the samples
  KeyRange FiniteRange;       ///< of the contoured values, of blocks that are not active too

  /// Set before: whether Source is to give samples that gradients can be made of, and those of the
  /// arrays to interpolate.
  bool Normals = false;
  bool Attributes = false;
  std::vector<InterpolatedArray> Arrays; ///< that are interpolated; what Source gives beside

  /// This rank's active blocks. What it refers to is in Owner.
  std::unique_ptr<BlockSource> Source;
  /// Numbers of these blocks, ascending: of all blocks of the grid, whichever rank has them. They
  /// are the same for any number of ranks.
  std::vector<std::int64_t> Numbers;
  std::shared_ptr<const void> Owner;
};

/// Which active blocks of a blocked volume: this rank's share of those of a level.
struct VolumeBlocksQuery
{
  std::size_t TimeStep = 0;
  std::size_t Variable = 0;
  int Level = 0;
  std::vector<std::size_t> Attributes;
  isosurface::Region Region;
  int Rank = 0;
  int Ranks = 1;
};

/// Fills in what follows from the volume and the query; Isovalues, ArrayName and Arrays are there.
Status CollectVolumeBlocks(const std::shared_ptr<BlockedVolume>& volume,
  const VolumeBlocksQuery& query, ContourBlocks& blocks);

/// The same of images that all ranks have pieces of. Collective: all ranks enter it, whatever
/// `status` they bring, and get the error of any. Scalars and attributes are those of the pieces.
Status CollectImageBlocks(Communicator& ranks, const Status& status,
  std::shared_ptr<ImagePieces> pieces, std::vector<ChosenScalars> scalars,
  std::vector<PieceAttributes> attributes, const Region& region, int threads,
  ContourBlocks& blocks);

} // namespace isosurface

#endif
