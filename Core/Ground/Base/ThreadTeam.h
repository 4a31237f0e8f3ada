// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ThreadTeam_h
#define isosurface_ThreadTeam_h

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * Threads that are kept until the team ends, for work that begins often. While a thread has a team,
 * its StartTask() and ParallelFor() use the team's threads instead of new ones.
 */
class ThreadTeam
{
public:
  /// Becomes the team of this thread, unless that has one.
  ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;
  /// Waits for all work. By the thread that made the team.
  ~ThreadTeam();

  /// The team of this thread, or null.
  static ThreadTeam* OfThisThread();

  /// Runs work that throws nothing, at once: if no thread of the team is idle, there is a new one.
  /// Throws std::system_error if the system gives none.
  void Run(std::function<void()> work);

private:
  void Serve();

  std::mutex Mutex;
  std::condition_variable Changed;
  std::deque<std::function<void()>> Waiting;
  std::size_t Idle = 0; ///< threads that wait for work
  bool HasEnded = false;
  std::vector<std::thread> Threads;
};

/// The result of work in another thread. The destructor waits for it, since the work uses what the
/// caller has.
template <typename T>
class Task
{
public:
  Task() = default;
  explicit Task(std::future<T> result)
    : Result(std::move(result))
  {
  }
  Task(Task&&) = default;
  Task& operator=(Task&& other) noexcept
  {
    this->Wait();
    this->Result = std::move(other.Result);
    return *this;
  }
  ~Task() { this->Wait(); }

  /// Waits for the result, once. Rethrows an exception of the work.
  T Get() { return this->Result.get(); }
  /// Gives the result away; the destructor no longer waits.
  std::shared_future<T> Share() { return this->Result.share(); }

private:
  void Wait() const
  {
    // Deferred work would only be done now.
    if (this->Result.valid() &&
      this->Result.wait_for(std::chrono::seconds(0)) != std::future_status::deferred)
    {
      this->Result.wait();
    }
  }

  std::future<T> Result;
};

/// Starts work in a thread of this thread's team, or else in a new one; without `isAhead`, the work
/// is done by Task::Get(). Throws std::system_error if there is no thread.
template <typename Work>
auto StartTask(Work work, bool isAhead = true)
{
  using T = decltype(work());
  if (!isAhead)
  {
    return Task<T>(std::async(std::launch::deferred, std::move(work)));
  }
  ThreadTeam* const team = ThreadTeam::OfThisThread();
  if (!team)
  {
    return Task<T>(std::async(std::launch::async, std::move(work)));
  }
  // A std::function is copied, and a task is not.
  auto task = std::make_shared<std::packaged_task<T()>>(std::move(work));
  Task<T> started(task->get_future());
  team->Run([task] { (*task)(); });
  return started;
}

} // namespace isosurface

#endif
