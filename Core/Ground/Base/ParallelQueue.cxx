// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/ParallelQueue.h"

#include "Ground/Base/ReadingStop.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>

namespace isosurface
{
namespace
{

/// The state of a call, which its threads share.
class QueueLoop
{
public:
  using Clock = std::chrono::steady_clock;
  using Take = std::function<std::vector<std::size_t>()>;
  using Body = std::function<void(std::size_t index, int thread)>;

  QueueLoop(
    const Take& take, std::size_t expected, int threads, const Body& body, const Progress& progress)
    : TakeMore(take)
    , Expected(expected)
    , Reserve(2 * static_cast<std::size_t>(threads) - 1)
    , Call(body)
    , Report(progress)
  {
  }

  /// The calling thread.
  void Lead()
  {
    try
    {
      while (const std::optional<std::size_t> index = this->RefillAndNext())
      {
        this->Call(*index, 0);
        this->ReportProgress();
      }
    }
    catch (...)
    {
      this->Fail();
    }
  }

  /// Any other thread.
  void Follow(int thread)
  {
    try
    {
      while (const std::optional<std::size_t> index = this->Next())
      {
        this->Call(*index, thread);
      }
    }
    catch (...)
    {
      this->Fail();
    }
    const std::lock_guard<std::mutex> lock(this->Mutex);
    ++this->Ended;
    this->Changed.notify_all();
  }

  /// Of the leading thread, which is asked meanwhile whether all are to stop (ReadingStop).
  void WaitForFollowers(std::size_t count)
  {
    constexpr std::chrono::milliseconds pause{ 100 };
    std::unique_lock<std::mutex> lock(this->Mutex);
    while (!this->Changed.wait_for(lock, pause, [&] { return this->Ended == count; }))
    {
      lock.unlock();
      static_cast<void>(ReadingStop::IsWanted());
      lock.lock();
    }
  }

  /// After all threads have stopped: whether all indices were visited.
  bool Finish()
  {
    if (this->Failure)
    {
      std::rethrow_exception(this->Failure);
    }
    return !this->Stopped && (!this->Report || this->Report(1));
  }

private:
  static constexpr std::chrono::milliseconds Pause{ 20 }; ///< between two reports

  /// The next index of the calling thread, which must not wait: nobody else takes more.
  std::optional<std::size_t> RefillAndNext()
  {
    std::unique_lock<std::mutex> lock(this->Mutex);
    while (!this->IsComplete && !this->Stopped && this->Waiting.size() < this->Reserve)
    {
      lock.unlock();
      const std::vector<std::size_t> more = this->TakeMore();
      lock.lock();
      this->Waiting.insert(this->Waiting.end(), more.begin(), more.end());
      this->Taken += more.size();
      this->IsComplete = more.empty();
      this->Changed.notify_all();
    }
    return this->PopFront();
  }

  /// The next index of another thread, which waits for one if need be.
  std::optional<std::size_t> Next()
  {
    std::unique_lock<std::mutex> lock(this->Mutex);
    this->Changed.wait(
      lock, [this] { return !this->Waiting.empty() || this->IsComplete || this->Stopped; });
    return this->PopFront();
  }

  /// Nothing if there are no more. The mutex must be locked.
  std::optional<std::size_t> PopFront()
  {
    if (this->Waiting.empty() || this->Stopped)
    {
      return std::nullopt;
    }
    const std::size_t index = this->Waiting.front();
    this->Waiting.pop_front();
    return index;
  }

  void ReportProgress()
  {
    const auto now = Clock::now();
    if (!this->Report || now < this->NextTime)
    {
      return;
    }
    this->NextTime = now + Pause;
    std::size_t done = 0;
    std::size_t all = 0;
    {
      const std::lock_guard<std::mutex> lock(this->Mutex);
      done = this->Taken - this->Waiting.size();
      all = this->IsComplete ? this->Taken : std::max(this->Taken, this->Expected);
    }
    // Some may be in the hands of other threads, or still to come.
    const double fraction = static_cast<double>(done) / static_cast<double>(all + 1);
    this->Fraction = std::max(this->Fraction, fraction);
    if (!this->Report(this->Fraction))
    {
      this->Stop();
    }
  }

  void Stop()
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->Stopped = true;
    this->Changed.notify_all();
  }

  void Fail()
  {
    {
      const std::lock_guard<std::mutex> lock(this->Mutex);
      this->Failure = std::current_exception();
    }
    this->Stop();
  }

  const Take& TakeMore;
  const std::size_t Expected;
  const std::size_t Reserve; ///< of indices that should wait
  const Body& Call;
  const Progress& Report;
  Clock::time_point NextTime = Clock::now() + Pause;
  double Fraction = 0; ///< that was last reported: there may be more indices than were expected

  std::mutex Mutex; ///< guards what follows
  std::condition_variable Changed;
  std::deque<std::size_t> Waiting;
  std::size_t Taken = 0;
  bool IsComplete = false; ///< whether all indices are known
  bool Stopped = false;
  std::exception_ptr Failure;
  std::size_t Ended = 0; ///< following threads
};

} // namespace

bool ParallelQueue(const std::function<std::vector<std::size_t>()>& take, std::size_t expected,
  int threads, const std::function<void(std::size_t, int)>& body, const Progress& progress)
{
  const int useful = std::max(1, threads);
  QueueLoop loop(take, expected, useful, body, progress);
  std::vector<std::thread> helpers;
  helpers.reserve(static_cast<std::size_t>(useful));
  try
  {
    for (int thread = 1; thread < useful; ++thread)
    {
      helpers.emplace_back(
        [&loop, thread, token = ReadingStop::Share()]
        {
          const ReadingStop stop(token);
          loop.Follow(thread);
        });
    }
  }
  catch (const std::system_error&)
  {
    // The system gives no more threads: those that are there do the work.
  }
  loop.Lead();
  loop.WaitForFollowers(helpers.size());
  for (std::thread& helper : helpers)
  {
    helper.join();
  }
  return loop.Finish();
}

} // namespace isosurface
