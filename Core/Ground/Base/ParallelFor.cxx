// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/ParallelFor.h"

#include "Ground/Base/ReadingStop.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace isosurface
{
namespace
{

/// The state of a call, which its threads share.
class IndexLoop
{
public:
  using Clock = std::chrono::steady_clock;
  using Body = std::function<void(std::size_t index, int thread)>;

  IndexLoop(std::size_t count, const Body& body, const Progress& progress)
    : Count(count)
    , Call(body)
    , Report(progress)
    , Step(std::max<std::size_t>(1, count / 100))
  {
  }

  /// Works on indices until none is left. Thread 0 is the calling one.
  void Run(int thread)
  {
    try
    {
      for (std::size_t index; !this->Stopped && (index = this->Next.fetch_add(1)) < this->Count;)
      {
        this->Call(index, thread);
        if (thread == 0)
        {
          this->ReportProgress(index);
        }
      }
    }
    catch (...)
    {
      const std::lock_guard<std::mutex> lock(this->FailureMutex);
      this->Failure = std::current_exception();
      this->Stopped = true;
    }
  }

  /// Of a helper, and of the calling thread, which is asked meanwhile whether all are to stop.
  void TellEnd()
  {
    const std::lock_guard<std::mutex> lock(this->EndMutex);
    ++this->Ended;
    this->HasEnded.notify_all();
  }
  void WaitForEnds(std::size_t helpers)
  {
    std::unique_lock<std::mutex> lock(this->EndMutex);
    constexpr std::chrono::milliseconds pause{ 100 };
    while (!this->HasEnded.wait_for(lock, pause, [&] { return this->Ended == helpers; }))
    {
      static_cast<void>(ReadingStop::IsWanted());
    }
  }

  /// After all threads have stopped: whether all indices were visited.
  bool Finish()
  {
    if (this->Failure)
    {
      std::rethrow_exception(this->Failure);
    }
    if (!this->Stopped && this->Report && this->Count > 0 && this->Fraction < 1)
    {
      // If the other threads did all the work, the calling one has not reported progress yet.
      return this->Report(1);
    }
    return !this->Stopped;
  }

private:
  static constexpr std::chrono::milliseconds MaximumPause{ 20 }; ///< between two reports

  // Only the calling thread reports progress: a hundred times, and often enough to be stopped soon.
  void ReportProgress(std::size_t index)
  {
    if (!this->Report)
    {
      return;
    }
    const auto now = Clock::now();
    if (index < this->NextReport && now < this->NextTime)
    {
      return;
    }
    this->NextReport = index + this->Step;
    this->NextTime = now + MaximumPause;
    this->Fraction = static_cast<double>(index + 1) / static_cast<double>(this->Count);
    if (!this->Report(this->Fraction))
    {
      this->Stopped = true;
    }
  }

  const std::size_t Count;
  const Body& Call;
  const Progress& Report;
  const std::size_t Step; ///< indices from one report to the next
  std::size_t NextReport = 0;
  Clock::time_point NextTime = Clock::now() + MaximumPause;
  double Fraction = 0; ///< that was last reported
  std::atomic<std::size_t> Next{ 0 };
  std::atomic<bool> Stopped{ false };
  std::exception_ptr Failure;
  std::mutex FailureMutex;
  std::mutex EndMutex; ///< guards Ended
  std::condition_variable HasEnded;
  std::size_t Ended = 0; ///< helpers
};

} // namespace

int ChooseThreadCount(int processesOnNode)
{
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return std::max(1, cores / std::max(1, processesOnNode));
}

bool ParallelFor(std::size_t count, int threads, const std::function<void(std::size_t, int)>& body,
  const Progress& progress)
{
  IndexLoop loop(count, body, progress);
  const std::size_t useful =
    std::min<std::size_t>(count, static_cast<std::size_t>(std::max(1, threads)));
  std::vector<std::thread> helpers;
  helpers.reserve(useful);
  const auto token = ReadingStop::Share();
  try
  {
    for (std::size_t thread = 1; thread < useful; ++thread)
    {
      helpers.emplace_back(
        [&, thread]
        {
          const ReadingStop stop(token);
          loop.Run(static_cast<int>(thread));
          loop.TellEnd();
        });
    }
  }
  catch (const std::system_error&)
  {
    // The system gives no more threads: those that are there do the work.
  }
  loop.Run(0);
  if (token)
  {
    loop.WaitForEnds(helpers.size());
  }
  for (std::thread& helper : helpers)
  {
    helper.join();
  }
  return loop.Finish();
}

} // namespace isosurface
