// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ParallelFor_h
#define isosurface_ParallelFor_h

#include "Ground/Base/Progress.h"

#include <algorithm>
#include <cstddef>
#include <functional>

namespace isosurface
{

/// The number of threads that each of `processesOnNode` processes on a node should use, at least 1.
int ChooseThreadCount(int processesOnNode);

/// Those of `threads` that `work` keeps busy, at least 1. A thread takes some 50 microseconds to
/// start, so each should have `least` of the work to do.
inline int LimitThreads(int threads, std::size_t work, std::size_t least)
{
  return static_cast<int>(
    std::min<std::size_t>(static_cast<std::size_t>(std::max(1, threads)), 1 + work / least));
}

/**
 * Calls body(index, thread) once for every index in [0, count), on `threads` threads, the calling
 * one included; `thread` is in [0, threads). A free thread takes the next index. Returns false if
 * `progress` asked to stop: then some indices may be missing. It is called a hundred times, or every
 * 20 ms if that is more often, and with 1 at the end.
 * Rethrows an exception of `body` after all threads have stopped.
 */
bool ParallelFor(std::size_t count, int threads,
  const std::function<void(std::size_t index, int thread)>& body, const Progress& progress = {});

} // namespace isosurface

#endif
