// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImageContour_h
#define isosurface_ImageContour_h

#include "ChosenScalars.h"
#include "ImagePieces.h"

#include "vtkType.h"

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/Region.h"
#include "Ranks/Islands/IslandChoice.h"
#include "Ranks/Query/LevelExtraction.h"
#include "Surface/Contour/BlockRanges.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Pieces/PieceLayers.h"
#include "SurfacePolyData.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

class vtkDataArray;

namespace isosurface
{

/// Which block of a composite each part of a surface is of. The same on all ranks.
struct SurfaceBlocks
{
  std::vector<std::int64_t> FirstIds; ///< of the grids: the first id of each
  std::vector<std::size_t> Numbers;   ///< of the grids, into Names
  std::vector<std::string> Names;
};

/// Of one execution, on this rank.
struct ContourOutcome : ExtractionOutcome
{
  std::vector<InterpolatedArray> Arrays; ///< of the surface's attributes
  std::string ArrayName;                 ///< of the contoured array
  SurfaceBlocks Blocks; ///< of the input, if it has several with surfaces of their own
  bool Final = true;    ///< whether a progressive surface is at its last level
  bool MayStay = false; ///< whether the next execution may have it stay
  bool Stays = false;   ///< whether nothing was extracted, and the last surface stays
  std::size_t ExtractedTriangles = 0;   ///< before islands were left out
  std::optional<ChosenIslands> Islands; ///< if they were asked for
  double IslandSeconds = 0;             ///< wall clock of finding and choosing them
};

/**
 * Isosurfaces of images in memory. The value ranges of their blocks, and magnitudes of vectors, are
 * kept from one extraction to the next, for as long as the images stay the same.
 */
class ImageContour
{
public:
  struct Settings
  {
    int Component = 0;               ///< as vtkStabbingContour::SetComponent takes it
    std::vector<std::string> Arrays; ///< to interpolate
    isosurface::Region Region;
    int Threads = 1;
    CellAverages* Averages = nullptr; ///< of the arrays to interpolate; must be there
  };

  /// What is to be extracted. The arrays stay alive with it; what is hidden needs the images.
  struct Query
  {
    /// Collective. Errors: those of FindAttributes; InvalidArgument for arrays that are not of the
    /// same types in all images of a rank.
    static Result<Query> Make(Communicator& ranks, ImagePieces pieces, const Settings& settings,
      const ContourRequest& request);

    /// The same of every 2^level-th vertex of the grids, without a copy of samples. `joins`: pieces
    /// may end between these vertices, so they are contoured as one.
    Query Coarsen(int level, bool joins) const;

    /// The grids, and the planes in which their pieces meet.
    IslandGrids MakeIslandGrids(const Communicator& ranks) const;

    ImagePieces Pieces;
    std::vector<PieceAttributes> Attributes; ///< of each piece
    std::vector<InterpolatedArray> Arrays;
    ContourRequest Request; ///< its attributes are those of Arrays
    Settings Choice;
    /// Whether the blocks of whole grids are contoured, each by one rank, which is sent what it does
    /// not have; else those of each piece.
    bool Joins = false;
  };

  /**
   * The surface of this rank's pieces. The ids of several grids follow each other. Normals where
   * pieces of a grid meet are those of the whole grid. Pieces with gaps between them, or of
   * different types, are contoured one by one in any case. Collective. It touches arrays alone, so
   * another thread may call it than the one that runs the pipeline.
   *
   * Errors: those of BlockRanges::Compute; Aborted when `progress` says so.
   */
  Status Extract(
    Communicator& ranks, const Query& query, const Progress& progress, ContourOutcome& outcome);

private:
  /// An array is known by its address and by when it or its image was modified.
  struct Entry
  {
    vtkDataArray* Array = nullptr;
    vtkMTimeType Time = 0;
    VertexBox Box;
    ChosenScalars Scalars;
    BlockRanges Ranges;
  };

  /// That of the last extraction, which is taken out, or one that is computed.
  Result<Entry> TakeEntry(const ImagePiece& piece, int component, int threads);

  /// What the pieces are contoured with.
  struct Prepared
  {
    std::vector<Entry> Entries;
    std::vector<LayeredPiece> Pieces;
    PieceLayers Layers;
  };

  /// Not collective.
  Status Prepare(const Query& query, Prepared& prepared);
  Status ExtractPrepared(
    const Query& query, Prepared& prepared, const Progress& progress, ContourOutcome& outcome);

  /// See Extract. Both are collective.
  Status ExtractPieces(
    Communicator& ranks, const Query& query, const Progress& progress, ContourOutcome& outcome);
  /// Errors: those of PieceBlockSource::Make and ExtractSurface.
  static Status ExtractJoined(
    Communicator& ranks, const Query& query, const Progress& progress, ContourOutcome& outcome);

  static Result<Surface> ExtractPiece(
    const Query& query, std::size_t number, const Prepared& prepared, const Progress& progress);

  std::vector<Entry> Entries; ///< of the last extraction
};

} // namespace isosurface

#endif
