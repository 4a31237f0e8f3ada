// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FirstFailure_h
#define isosurface_FirstFailure_h

#include "Ground/Base/Status.h"

#include <atomic>
#include <mutex>
#include <utility>

namespace isosurface
{

/// The first failure of steps that several threads run; no step is begun after it.
class FirstFailure
{
public:
  /// Runs a step, which returns a Status.
  template <typename Step>
  void Run(const Step& step)
  {
    if (!this->HasFailed)
    {
      this->Keep(step());
    }
  }

  void Keep(Status outcome)
  {
    if (!outcome.IsOk())
    {
      const std::lock_guard<std::mutex> lock(this->Mutex);
      if (!this->HasFailed.exchange(true))
      {
        this->Failure = std::move(outcome);
      }
    }
  }

  /// Also while steps run.
  bool IsFound() const { return this->HasFailed; }

  /// Only when no step runs any more.
  const Status& Get() const { return this->Failure; }

private:
  std::atomic<bool> HasFailed{ false };
  std::mutex Mutex;
  Status Failure;
};

} // namespace isosurface

#endif
