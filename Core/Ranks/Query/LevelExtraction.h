// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LevelExtraction_h
#define isosurface_LevelExtraction_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ranks/Islands/IslandChoice.h"
#include "Ranks/Query/LevelChoice.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/QueryStatistics.h"
#include "Surface/Contour/Surface.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

namespace isosurface
{

/// The cost of a query on one rank.
struct QueryCost
{
  QueryStatistics Reading;
  std::uint64_t Triangles = 0;
  int Level = 0;                     ///< of the surface
  std::optional<LevelChoice> Choice; ///< of the level, within a budget
  double ExtractSeconds = 0; ///< wall clock of extraction, with the reading that it waited for
};

/// What to extract of a blocked volume, and how.
struct ExtractionTask
{
  std::shared_ptr<BlockedVolume> Volume;
  SurfaceQuery Query;
  ContourRequest Request;
  int Threads = 1;
  Progress Advance;
  /// If given, ranks that are ready take blocks from the shares of others, where every rank reaches
  /// every store (not BlockedVolume::HasLocalStores) and the query's ranks are the communicator's.
  /// What is extracted is the same in all, but which rank has which block may differ from call to
  /// call.
  Communicator* Sharing = nullptr;
};

struct ExtractionOutcome
{
  Surface Extracted;
  QueryCost Cost;     ///< added to
  double Seconds = 0; ///< wall clock of the extraction, the query included

  std::size_t ExtractedTriangles = 0; ///< before islands were left out
  ChosenIslands Islands;              ///< if they were asked for
  double IslandSeconds = 0;           ///< wall clock of finding and choosing them
};

/// This rank's part of the surface at a level. Collective if blocks are shared (`Sharing`), else
/// not. Errors: those of reading the volume; Aborted when the progress says so. They are this
/// rank's alone: the other ranks extract the blocks that a failed rank has left.
Status ExtractLevel(const ExtractionTask& task, int level, ExtractionOutcome& outcome);

/// The same by `extract`, which fills in the surface and adds to the reading: what is common to all
/// extractions at a level. A lack of memory is an error of the volume.
Status RunExtraction(const ExtractionTask& task, int level, ExtractionOutcome& outcome,
  const std::function<Status()>& extract);

/// Ends an extraction at outcome.Cost.Level, whose status on this rank is `extracted`: chooses among the islands if
/// they are asked for, which makes an error one of all ranks. Collective then.
Status ChooseIslands(Communicator& ranks, const Status& extracted,
  const std::optional<IslandRequest>& islands, const std::function<IslandGrids()>& makeGrids,
  int threads, ExtractionOutcome& outcome);

/// The grid of that surface, whose pieces on several ranks meet at the faces of blocks.
IslandGrids MakeIslandGrids(const ExtractionTask& task, int level, const Communicator& ranks);

} // namespace isosurface

#endif
