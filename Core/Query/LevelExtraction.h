// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LevelExtraction_h
#define isosurface_LevelExtraction_h

#include "Query/QueryCost.h"

#include "Base/Progress.h"
#include "Base/Status.h"
#include "Contour/Surface.h"
#include "Query/LevelChoice.h"
#include "Store/BlockedVolume.h"

namespace isosurface
{

/// What to extract of a blocked volume, and how. The references must outlive the extraction.
struct ExtractionTask
{
  BlockedVolume& Volume;
  const SurfaceQuery& Query;
  const ContourRequest& Request;
  int Threads = 1;
  Progress Advance;
};

struct ExtractionOutcome
{
  Surface Extracted;
  QueryCost Cost;     ///< added to
  double Seconds = 0; ///< wall clock of the extraction, the query included
};

/// This rank's part of the surface at a level; not collective. Errors: those of reading the volume;
/// Aborted when the progress says so.
Status ExtractLevel(const ExtractionTask& task, int level, ExtractionOutcome& outcome);

} // namespace isosurface

#endif
