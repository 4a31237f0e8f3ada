// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PieceFields_h
#define isosurface_PieceFields_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/SampleView.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// A piece of a grid, as far as it tells which field it is a part of.
struct FieldPiece
{
  std::size_t Grid = 0;               ///< that has its vertices
  std::vector<SampleView> Components; ///< Box is what the piece contours
  std::vector<std::int64_t> Block;    ///< the path of its block in the input
  VertexBox Whole;                    ///< its samples, or more, as far as it knows
  bool IsDeclared = false;            ///< whether Whole is that of the pieces of its block
  bool Hides = false;                 ///< whether it has hidden cells or vertices
};

/// The samples of one scalar field on a grid.
struct GridField
{
  std::size_t Grid = 0;
  VertexBox Box;                   ///< around the Whole of all pieces
  std::vector<std::int64_t> Block; ///< of its first piece
};

/**
 * Which pieces are parts of one field. Pieces of a grid are, if they have vertices in common and
 * equal samples there (NaN equals NaN), directly or through others, and if no two of them differ.
 * Where that leaves a choice, pieces that are close in the input come first. Pieces of a block that
 * declares its whole are parts of it unless they have other samples in the same cells. Of two
 * blocks, one of which has all cells of the other, each is a field of its own: a copy.
 */
struct PieceFields
{
  /**
   * Collective. Cost: a box of each piece to all ranks; the samples that two pieces have in common
   * are read, and of those on different ranks a checksum goes to all. The fields depend on the pieces
   * and not on their ranks. `describe` gives this rank's pieces. The error may be this rank's alone.
   */
  static Result<PieceFields> Find(Communicator& ranks,
    const std::function<Result<std::vector<FieldPiece>>()>& describe, int threads);

  std::vector<GridField>
    Fields; ///< the same on all ranks; by grid, then in the order of the blocks
  /// Of this rank's pieces, their fields.
  std::vector<std::size_t> Numbers;
  /// Of this rank's pieces, what each contours: each cell of a field belongs to its first piece.
  std::vector<std::vector<VertexBox>> Boxes;
};

} // namespace isosurface

#endif
