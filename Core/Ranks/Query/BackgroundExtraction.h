// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BackgroundExtraction_h
#define isosurface_BackgroundExtraction_h

#include "Ranks/Query/LevelExtraction.h"

#include "Ground/Base/Status.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace isosurface
{

/**
 * An extraction beside the calling thread: it begins when the object is made, and stops when the
 * object goes, which takes as long as a block. Its threads have a lower priority than the calling
 * one where the system knows priorities of threads (Linux), so that what a user waits for goes
 * first. The surface is that of ExtractLevel, bit for bit.
 *
 * All functions are for one thread, the one that made the object.
 */
class BackgroundExtraction
{
public:
  /// Extracts a level. The task's progress is not called; blocks are not shared.
  BackgroundExtraction(ExtractionTask task, int level);
  ~BackgroundExtraction();
  BackgroundExtraction(const BackgroundExtraction&) = delete;
  BackgroundExtraction& operator=(const BackgroundExtraction&) = delete;

  const ExtractionTask& GetTask() const { return this->Task; }
  int GetLevel() const { return this->Level; }

  /// Asks it to stop, without waiting for that.
  void Stop() { this->Stopped = true; }
  /// Sleeps until the extraction has ended, but not longer than this; whether it has.
  bool Wait(double seconds);
  /// The finished fraction, 0 to 1.
  double GetProgress() const { return this->Done; }

  /// Waits for the end, and hands the surface over: its statistics are added to the outcome's.
  /// `advance` is called meanwhile. Errors: those of ExtractLevel; Aborted when `advance` says so.
  Status Take(const Progress& advance, ExtractionOutcome& outcome);

private:
  void Run();

  ExtractionTask Task;
  const int Level;
  std::atomic<double> Done{ 0 };
  std::atomic<bool> Stopped{ false };
  std::mutex Mutex;
  std::condition_variable Ended;
  bool HasEnded = false; ///< guarded by the mutex; what follows is settled then
  Status EndStatus;
  ExtractionOutcome Outcome;
  std::thread Thread; ///< the last member: it uses the others
};

} // namespace isosurface

#endif
