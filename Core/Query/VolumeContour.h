// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeContour_h
#define isosurface_VolumeContour_h

#include "Query/QueryCost.h"

#include "Base/Communicator.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Contour/SurfaceExtractor.h"
#include "Query/ExtractionRate.h"
#include "Query/LevelChoice.h"
#include "Store/BlockedVolume.h"

namespace isosurface
{

/// Extracts isosurfaces of blocked volumes, at a given level or at the finest one that a budget
/// allows. It learns this machine's speed from every extraction.
class VolumeContour
{
public:
  /// What to extract, and how. The references must outlive the extraction.
  struct Task
  {
    BlockedVolume& Volume;
    const SurfaceQuery& Query;
    const ContourRequest& Request;
    int Threads = 1;
    Progress Advance;
  };

  struct Outcome
  {
    Surface Extracted;
    QueryCost Cost; ///< added to
  };

  /// This rank's part of the surface at `choice.Level`; not collective. Errors: those of reading
  /// the volume; Aborted when the progress says so.
  Status ExtractAtLevel(const Task& task, const LevelChoice& choice, Outcome& outcome);

  /// The same at the finest level, `finest` or coarser, that is expected to keep the budget. One
  /// that turns out to have more triangles is given up for the next. Collective.
  Status ExtractWithinBudget(Communicator& ranks, const ExtractionBudget& budget, const Task& task,
    int finest, Outcome& outcome);

  const ExtractionRate& GetRate() const { return this->Rate; }

private:
  ExtractionRate Rate;
};

} // namespace isosurface

#endif
