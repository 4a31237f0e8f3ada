// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/BackgroundTask.h"

#include "Ground/Base/ReadingStop.h"

#include <chrono>
#include <utility>

#ifdef __linux__
#  include <sys/resource.h>
#  include <sys/syscall.h>
#  include <unistd.h>
#endif

namespace isosurface
{

void LowerThreadPriority()
{
#ifdef __linux__
  constexpr int lower = 5;
  // Linux has a nice value for each thread. Without it the work is done as well.
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  const int priority = getpriority(PRIO_PROCESS, thread);
  static_cast<void>(setpriority(PRIO_PROCESS, thread, priority + lower));
#endif
}

BackgroundTask::BackgroundTask(std::string context, Work work)
  : Thread(
      [this, context = std::move(context), work = std::move(work)] { this->Run(context, work); })
{
}

BackgroundTask::~BackgroundTask()
{
  this->Stop();
  this->Thread.join();
}

void BackgroundTask::Run(const std::string& context, const Work& work)
{
  LowerThreadPriority();
  const Progress advance = [this](double fraction)
  {
    this->Done = fraction;
    return !this->Stopped;
  };
  const Progress look = [this](double) { return !this->Stopped; };
  const ReadingStop stop(look);
  this->EndStatus = Attempt(context, [&] { return work(advance); });
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->HasEnded = true;
  this->Ended.notify_all();
}

bool BackgroundTask::Wait(double seconds)
{
  std::unique_lock<std::mutex> lock(this->Mutex);
  return this->Ended.wait_for(
    lock, std::chrono::duration<double>(seconds), [this] { return this->HasEnded; });
}

} // namespace isosurface
