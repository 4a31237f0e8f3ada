// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ParallelQueue_h
#define isosurface_ParallelQueue_h

#include "Ground/Base/Progress.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace isosurface
{

/**
 * Calls body(index, thread) once for every index that `take` returns, on `threads` threads, the
 * calling one included; `thread` is in [0, threads). Only the calling thread calls `take`, between
 * its own indices, as soon as fewer indices wait than keep the other threads busy meanwhile: about
 * two a thread. `take` returns some indices, or none if there are no more; it is not called again
 * then.
 *
 * `expected` is about how many there will be, for `progress`, which is called every 20 ms, and with
 * 1 at the end. Returns false if it asked to stop: then some indices may be missing. Rethrows an
 * exception of `body` or `take` after all threads have stopped.
 */
bool ParallelQueue(const std::function<std::vector<std::size_t>()>& take, std::size_t expected,
  int threads, const std::function<void(std::size_t index, int thread)>& body,
  const Progress& progress = {});

} // namespace isosurface

#endif
