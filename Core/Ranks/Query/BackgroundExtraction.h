// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BackgroundExtraction_h
#define isosurface_BackgroundExtraction_h

#include "Ranks/Query/LevelExtraction.h"

#include "Ground/Base/CollectiveTask.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"

#include <functional>

namespace isosurface
{

/**
 * An extraction beside the calling threads (CollectiveTask). It stops within a block. The surface is
 * that of an extraction in the calling threads, bit for bit.
 *
 * All functions are for one thread, the one that made the object.
 */
class BackgroundExtraction
{
public:
  using Extraction =
    std::function<Status(Communicator& ranks, const Progress& advance, ExtractionOutcome& outcome)>;

  /// Begins. Collective.
  BackgroundExtraction(Communicator& ranks, Extraction extract);

  CollectiveTask& GetWork() { return this->Work; }

  /// Waits for the end, and hands the surface over: its statistics are added to the outcome's.
  /// `advance` is called meanwhile. Errors: those of the extraction; Aborted when `advance` says so.
  /// Collective.
  Status Take(Communicator& ranks, const Progress& advance, ExtractionOutcome& outcome);

private:
  ExtractionOutcome Outcome; ///< the thread's until it has ended
  CollectiveTask Work;       ///< the last member: it uses the other one
};

} // namespace isosurface

#endif
