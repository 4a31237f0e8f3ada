// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MemoryContour_h
#define isosurface_MemoryContour_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ChosenScalars.h"
#include "Ground/Volume/Region.h"
#include "Ranks/Islands/IslandChoice.h"
#include "Ranks/Query/LevelExtraction.h"
#include "Surface/Contour/BlockRanges.h"
#include "Surface/Pieces/MemoryGrids.h"
#include "Surface/Pieces/PieceBlockSource.h"
#include "Surface/Pieces/PieceLayers.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/// What is to be extracted of grids in memory.
struct MemoryQuery
{
  MemoryGrids Samples;
  int Component = 0; ///< as FindChosenComponent takes it
  isosurface::Region Region;
  int Threads = 1;
  ContourRequest Request;
  /// Whether the blocks of whole grids are contoured, each by one rank, which is sent the samples
  /// that it lacks; else the blocks of each piece.
  bool Joins = false;

  /// The same of every 2^level-th vertex, in views of the same samples.
  MemoryQuery Coarsen(int level, bool joins) const;
  /// The first id of each grid, and the one behind the last.
  std::vector<std::int64_t> FindFirstIds() const;
  /// The block of each point of a surface of the grids; `blocks` are those of the grids (CollectedGrids::Blocks).
  std::vector<std::int32_t> FindBlocks(
    const Surface& surface, const std::vector<std::size_t>& blocks) const;
  /// The grids of the surface. `ranks`: not collective.
  IslandGrids MakeIslandGrids(const Communicator& ranks) const;
};

/// A query whose grids are contoured as a whole, with the blocks of this rank.
struct JoinedGrids
{
  /// Of several queries at once (PieceBlockSource::MakeAll). `prepared`: whether this rank has them.
  /// Collective.
  static Result<std::vector<JoinedGrids>> Make(
    Communicator& ranks, const Status& prepared, std::vector<MemoryQuery> queries);

  /// That of a source, InvalidArgument first, which all ranks have alike.
  Status FindFault() const;

  MemoryQuery Query;
  std::vector<ChosenScalars> Scalars;                     ///< of the pieces
  std::vector<std::unique_ptr<PieceBlockSource>> Sources; ///< of the grids; refer to Scalars
};

/**
 * Isosurfaces of grids in memory. The value ranges of their blocks, and magnitudes of vectors, are
 * kept from one extraction to the next, for as long as the samples stay the same.
 */
class MemoryContour
{
public:
  /**
   * The surface of this rank's pieces, or of its blocks of joined grids. The ids of several grids follow each
   * other. Normals where pieces of a grid meet are those of the whole grid. Pieces with gaps between them, or
   * of different types, are contoured one by one in any case. `prepared`: whether this rank has the query.
   * Collective.
   *
   * Errors, this rank's or those of all: that of `prepared`; those of BlockRanges::Compute and MakeAll of
   * PieceBlockSource; Aborted when `progress` says so.
   */
  Status Extract(Communicator& ranks, const Status& prepared, const MemoryQuery& query,
    const Progress& progress, ExtractionOutcome& outcome);
  Status Extract(Communicator& ranks, const JoinedGrids& joined, const Progress& progress,
    ExtractionOutcome& outcome);

private:
  struct Entry
  {
    std::uint64_t Identity = 0; ///< of the piece
    VertexBox Box;
    ChosenScalars Scalars;
    BlockRanges Ranges;
  };

  /// That of the last extraction, which is taken out, or one that is computed.
  Result<Entry> TakeEntry(const MemoryPiece& piece, int choice, int threads);

  /// What the pieces are contoured with.
  struct Prepared
  {
    std::vector<Entry> Entries;
    std::vector<LayeredPiece> Pieces;
    PieceLayers Layers;
  };

  /// Not collective.
  Status Prepare(const MemoryQuery& query, Prepared& prepared);
  Status ExtractPrepared(const MemoryQuery& query, Prepared& prepared, const Progress& progress,
    ExtractionOutcome& outcome);

  /// See Extract. Collective.
  Status ExtractPieces(Communicator& ranks, const Status& prepared, const MemoryQuery& query,
    const Progress& progress, ExtractionOutcome& outcome);
  static Status ExtractJoined(
    const JoinedGrids& joined, const Progress& progress, ExtractionOutcome& outcome);

  static Result<Surface> ExtractPiece(const MemoryQuery& query, std::size_t number,
    const Prepared& prepared, const Progress& progress);

  std::vector<Entry> Entries; ///< of the last extraction
};

} // namespace isosurface

#endif
