// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ParallelFor_h
#define isosurface_ParallelFor_h

#include "Base/Progress.h"

#include <cstddef>
#include <functional>

namespace isosurface
{

/// The number of threads that one of `processesOnNode` equal processes should use, at least 1.
int ChooseThreadCount(int processesOnNode);

/**
 * Calls body(index, thread) once for every index in [0, count), on `threads` threads (the caller's
 * among them; thread is 0 .. threads - 1), each index as soon as a thread is free. Returns false if
 * `progress`, which is told 1 at the end, asked to stop; then some indices may be left out. An
 * exception thrown by a body is thrown again from here after all threads have stopped.
 */
bool ParallelFor(std::size_t count, int threads,
  const std::function<void(std::size_t index, int thread)>& body, const Progress& progress = {});

} // namespace isosurface

#endif
