// SPDX-License-Identifier: BSD-3-Clause
#include "Base/ParallelFor.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace isosurface
{

int ChooseThreadCount(int processesOnNode)
{
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return std::max(1, cores / std::max(1, processesOnNode));
}

bool ParallelFor(std::size_t count, int threads, const std::function<void(std::size_t, int)>& body,
  const Progress& progress)
{
  std::atomic<std::size_t> next{ 0 };
  std::atomic<bool> stopped{ false };
  std::exception_ptr failure;
  std::mutex failureMutex;

  // Progress is told from the caller's thread alone, at most a hundred times.
  const std::size_t step = std::max<std::size_t>(1, count / 100);
  double share = 0;
  auto work = [&](int thread)
  {
    std::size_t told = 0;
    try
    {
      for (std::size_t index; !stopped && (index = next.fetch_add(1)) < count;)
      {
        body(index, thread);
        if (thread == 0 && progress && index >= told)
        {
          told = index + step;
          share = static_cast<double>(index + 1) / static_cast<double>(count);
          if (!progress(share))
          {
            stopped = true;
          }
        }
      }
    }
    catch (...)
    {
      const std::lock_guard<std::mutex> lock(failureMutex);
      failure = std::current_exception();
      stopped = true;
    }
  };

  const std::size_t useful =
    std::min<std::size_t>(count, static_cast<std::size_t>(std::max(1, threads)));
  std::vector<std::thread> helpers;
  for (std::size_t thread = 1; thread < useful; ++thread)
  {
    helpers.emplace_back(work, static_cast<int>(thread));
  }
  work(0);
  for (std::thread& helper : helpers)
  {
    helper.join();
  }
  if (failure)
  {
    std::rethrow_exception(failure);
  }
  if (!stopped && progress && count > 0 && share < 1)
  {
    // The others may have left nothing to the caller's thread: then it has not asked yet.
    return progress(1);
  }
  return !stopped;
}

} // namespace isosurface
