// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Sandbox_h
#define isosurface_Sandbox_h

#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"

#include <cstdint>
#include <functional>
#include <string>

namespace isosurface
{

/// What a process may take that reads the files of strangers.
struct SandboxLimits
{
  std::uint64_t MemoryBytes = 0; ///< of address space, besides what this process has already
  std::uint64_t FileBytes = 0;   ///< of each file that it writes
  std::uint64_t Seconds = 0;     ///< of processor time, until the progress grows again
};

/**
 * Does the work in a process of its own, a copy of this one, and returns what the work returned. That
 * process has the limits; otherwise it may do what this one may.
 *
 * A stop signal to this process stops the work. If this process ends, so does the other one.
 *
 * The work is told of an error if this system cannot limit its process (Unsupported); then it should read
 * nothing. What `RunInSandbox` returns as errors says how the process ended before the work was done:
 * Corrupt (it crashed), OutOfMemory (the system killed it), IoError (its time was over), Aborted (a second
 * stop signal), Unsupported (there is no such process).
 *
 * Call it in a process of one thread, as any function that forks.
 */
Result<int> RunInSandbox(
  const SandboxLimits& limits, const std::function<int(const Status& limited)>& work);

/// Whether this process is one that RunInSandbox() made.
bool IsInSandbox();

/// The same progress, which in a sandbox also renews the processor time when it grows. `progress` must
/// outlive it.
Progress RenewTimeWith(const Progress& progress);

} // namespace isosurface

#endif
