// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CollectedGrids_h
#define isosurface_CollectedGrids_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Surface/Pieces/MemoryGrids.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace isosurface
{

/// Samples of a grid that a rank has, before it knows those of the other ranks.
struct MemoryImage
{
  GridGeometry
    Grid; ///< its extent is that of these samples, or of what they are declared to be a part of
  std::optional<GridLines> Lines; ///< of a rectilinear grid
  bool IsDeclared = false;
  std::vector<std::int64_t> Block; ///< the path of its block in the input
  /// The samples, in the vertices of a grid that has them.
  std::function<Result<MemoryPiece>(const GridGeometry& grid)> MakePiece;

  /// Tells what they are a part of, an extent. What lines a rectilinear grid has beyond them is not known.
  template <typename Extent>
  void Declare(const Extent& whole)
  {
    this->IsDeclared = true;
    for (std::size_t axis = 0; !this->Lines && axis < 6; axis += 2)
    {
      this->Grid.Extent[axis] = std::min<std::int64_t>(this->Grid.Extent[axis], whole[axis]);
      this->Grid.Extent[axis + 1] =
        std::max<std::int64_t>(this->Grid.Extent[axis + 1], whole[axis + 1]);
    }
  }
};

/// The images of a rank.
struct MemoryImages
{
  std::vector<MemoryImage> Images;
  bool AreThere =
    false; ///< whether there are images, some of which may not have the array that is contoured
};

/**
 * The images of all ranks as pieces of grids (UniteGrids), then their rectilinear grids (UniteLinedGrids).
 * Images that are not parts of one field (PieceFields), as the members of an ensemble, have grids of their own.
 */
struct CollectedGrids : MemoryGrids
{
  std::vector<std::size_t> Images; ///< of the pieces: this rank's image; several may be of one
  std::vector<std::vector<std::int64_t>>
    Paths;                         ///< of the grids' first pieces: their blocks, ascending
  std::vector<std::size_t> Blocks; ///< of the grids, into Paths

  /// Collective. `describe`: this rank's images. Cost: PieceFields::Find. Errors: those of `describe` and of
  /// MakePiece; NotFound if there are images, but none on any rank with an array. An error may be this rank's
  /// alone.
  static Result<CollectedGrids> Collect(
    Communicator& ranks, const std::function<Result<MemoryImages>()>& describe, int threads);
};

} // namespace isosurface

#endif
