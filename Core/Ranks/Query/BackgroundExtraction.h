// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BackgroundExtraction_h
#define isosurface_BackgroundExtraction_h

#include "Ranks/Query/LevelExtraction.h"

#include "Ground/Base/BackgroundTask.h"
#include "Ground/Base/Status.h"

namespace isosurface
{

/**
 * An extraction beside the calling thread (BackgroundTask). It stops within a block. The surface is
 * that of ExtractLevel, bit for bit.
 *
 * All functions are for one thread, the one that made the object.
 */
class BackgroundExtraction
{
public:
  /// Extracts a level. The task's progress is not called; blocks are not shared.
  BackgroundExtraction(ExtractionTask task, int level);

  const ExtractionTask& GetTask() const { return this->Task; }
  int GetLevel() const { return this->Level; }

  /// Asks it to stop, without waiting for that.
  void Stop() { this->Work.Stop(); }
  /// Sleeps until the extraction has ended, but not longer than this; whether it has.
  bool Wait(double seconds) { return this->Work.Wait(seconds); }
  /// How it ended. Only after Wait() has returned true.
  const Status& GetStatus() const { return this->Work.GetStatus(); }
  /// The finished fraction, 0 to 1.
  double GetProgress() const { return this->Work.GetProgress(); }

  /// Waits for the end, and hands the surface over: its statistics are added to the outcome's.
  /// `advance` is called meanwhile. Errors: those of ExtractLevel; Aborted when `advance` says so.
  Status Take(const Progress& advance, ExtractionOutcome& outcome);

private:
  Status Extract(const Progress& advance);

  ExtractionTask Task;
  const int Level;
  ExtractionOutcome Outcome; ///< the thread's until it has ended
  BackgroundTask Work;       ///< the last member: it uses the others
};

} // namespace isosurface

#endif
