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
#include "Surface/Pieces/PieceLayers.h"

#include <cstddef>
#include <cstdint>
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
  /// The grids of the surface. `ranks`: not collective.
  IslandGrids MakeIslandGrids(const Communicator& ranks) const;
};

/**
 * Isosurfaces of grids in memory. The value ranges of their blocks, and magnitudes of vectors, are
 * kept from one extraction to the next, for as long as the samples stay the same.
 */
class MemoryContour
{
public:
  /**
   * The surface of this rank's pieces. The ids of several grids follow each other. Normals where
   * pieces of a grid meet are those of the whole grid. Pieces with gaps between them, or of
   * different types, are contoured one by one in any case. Collective.
   *
   * Errors: those of BlockRanges::Compute; Aborted when `progress` says so.
   */
  Status Extract(Communicator& ranks, const MemoryQuery& query, const Progress& progress,
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

  /// See Extract. Both are collective.
  Status ExtractPieces(Communicator& ranks, const MemoryQuery& query, const Progress& progress,
    ExtractionOutcome& outcome);
  /// Errors: those of PieceBlockSource::Make and ExtractSurface.
  static Status ExtractJoined(Communicator& ranks, const MemoryQuery& query,
    const Progress& progress, ExtractionOutcome& outcome);

  static Result<Surface> ExtractPiece(const MemoryQuery& query, std::size_t number,
    const Prepared& prepared, const Progress& progress);

  std::vector<Entry> Entries; ///< of the last extraction
};

} // namespace isosurface

#endif
