// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BackgroundTask_h
#define isosurface_BackgroundTask_h

#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace isosurface
{

/**
 * Gives the calling thread, and those that it starts, about a third of the processor time of other
 * threads of the process where there are not enough processors for all. On Linux; elsewhere, and if
 * the system refuses, threads stay as they are.
 */
void LowerThreadPriority();

/**
 * Work beside the calling thread: it begins when the object is made. Its threads have a lower
 * priority than the calling one where the system knows priorities of threads (Linux), so that what
 * a user waits for goes first. The destructor stops the work and waits until it has stopped: until
 * it next reports its progress.
 *
 * All functions are for one thread, the one that made the object.
 */
class BackgroundTask
{
public:
  using Work = std::function<Status(const Progress& advance)>;

  /// `context` is what cannot be done, for errors without a file (Attempt).
  BackgroundTask(std::string context, Work work);
  ~BackgroundTask();
  BackgroundTask(const BackgroundTask&) = delete;
  BackgroundTask& operator=(const BackgroundTask&) = delete;

  /// Asks the work to stop, without waiting for that.
  void Stop() { this->Stopped = true; }
  /// Sleeps until the work has ended, but not longer than this; whether it has.
  bool Wait(double seconds);
  /// The finished fraction, 0 to 1.
  double GetProgress() const { return this->Done; }
  /// How it ended. Only after Wait() has returned true.
  const Status& GetStatus() const { return this->EndStatus; }

private:
  void Run(const std::string& context, const Work& work);

  std::atomic<double> Done{ 0 };
  std::atomic<bool> Stopped{ false };
  std::mutex Mutex;
  std::condition_variable Ended;
  bool HasEnded = false; ///< guarded by the mutex; what follows is settled then
  Status EndStatus;
  std::thread Thread; ///< the last member: it uses the others
};

} // namespace isosurface

#endif
