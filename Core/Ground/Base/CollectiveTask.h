// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CollectiveTask_h
#define isosurface_CollectiveTask_h

#include "Ground/Base/BackgroundTask.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/RelayedCommunicator.h"
#include "Ground/Base/Status.h"

#include <functional>
#include <memory>
#include <string>

namespace isosurface
{

/**
 * Work of all ranks beside their calling threads (BackgroundTask, RelayedCommunicator). Where there
 * are several ranks, it goes on beyond a collective only while all of them are in Advance().
 *
 * The destructor stops the work of this rank.
 */
class CollectiveTask
{
public:
  using Work = std::function<Status(Communicator& ranks, const Progress& advance)>;

  /// Begins. `context`: as for BackgroundTask. Collective.
  CollectiveTask(Communicator& ranks, std::string context, Work work);
  ~CollectiveTask();
  CollectiveTask(const CollectiveTask&) = delete;
  CollectiveTask& operator=(const CollectiveTask&) = delete;

  /// Whether there are several ranks.
  bool IsCollective() const { return this->Relay != nullptr; }
  /// Asks it to stop, without waiting for that.
  void Stop() { this->Task->Stop(); }
  /// Waits for the end, at most `seconds`; whether the work has ended on all ranks.
  /// Collective.
  bool Advance(Communicator& ranks, double seconds);
  /// Waits for the end, and tells how it ended; Aborted if the progress of any rank says so before.
  /// Collective.
  Status Finish(Communicator& ranks, const Progress& progress);
  /// Waits as long, but for this rank alone, and not for what needs all ranks in Advance().
  bool WaitAlone(double seconds) { return this->Task->Wait(seconds); }
  /// Whether this rank has come to the end.
  bool HasEnded() { return this->WaitAlone(0); }
  /// The finished fraction, 0 to 1.
  double GetProgress() const { return this->Task->GetProgress(); }
  /// How it ended. Only after the end.
  const Status& GetStatus() const { return this->Task->GetStatus(); }

private:
  std::unique_ptr<RelayedCommunicator> Relay; ///< null for one rank
  std::unique_ptr<BackgroundTask> Task;       ///< goes first: it uses the relay
};

} // namespace isosurface

#endif
