// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PythonErrors_h
#define isosurface_PythonErrors_h

#include "Ground/Base/Progress.h"
#include "Ground/Base/ReadingStop.h"
#include "Ground/Base/Status.h"

#include <pybind11/pybind11.h>

#include <chrono>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

namespace isosurface
{

/**
 * Throws what Python calls an error, if it is one: FileNotFoundError, OSError, ValueError or
 * MemoryError, with the message of the status. The GIL is held.
 */
void ThrowIfError(const Status& status);

/// A UserWarning of Python, unless the message is empty. The GIL is held.
void Warn(const std::string& message);

/// The value of a result, or ThrowIfError.
template <typename T>
T TakeValue(Result<T> result)
{
  ThrowIfError(result.GetStatus());
  return std::move(*result);
}

/// Stops work when a signal has come whose handler raises an exception, as Ctrl+C does, or when a warning
/// raises one.
class SignalWatch
{
public:
  /// For work of the calling thread, which does not hold the GIL. It takes it ten times a second.
  Progress GetProgress();
  /// A UserWarning of that work. Where warnings are errors, it stops.
  void Warn(const std::string& message);
  /// Throws what a handler or a warning has raised. The GIL is held.
  void Rethrow() const;

private:
  bool Look();

  std::chrono::steady_clock::time_point LastLook = std::chrono::steady_clock::now();
  std::optional<pybind11::error_already_set> Raised;
};

/// Has a process that is forked while a thread is at work refuse work, since what that thread held it holds
/// for ever.
void WatchForks();

/// Work without the GIL, for WatchForks(). Throws a RuntimeError where it is refused.
class WorkWithoutGil
{
public:
  WorkWithoutGil() = default;
  WorkWithoutGil(const WorkWithoutGil&) = delete;
  WorkWithoutGil& operator=(const WorkWithoutGil&) = delete;

private:
  struct Worker
  {
    Worker();
    ~Worker();
  };
  const Worker Counted; ///< before the GIL is released
  const pybind11::gil_scoped_release Released;
};

/// Calls work(progress) without the GIL, and returns its value; throws its error. Exceptions of C++
/// are errors about `path`.
template <typename Work>
auto RunWithoutGil(const std::string& path, const Work& work)
{
  SignalWatch watch;
  auto result = [&]
  {
    const WorkWithoutGil released;
    const Progress progress = watch.GetProgress();
    const ReadingStop stop(progress);
    return Attempt(path, [&] { return work(progress); });
  }();
  watch.Rethrow();
  if constexpr (std::is_same_v<decltype(result), Status>)
  {
    ThrowIfError(result);
  }
  else
  {
    return TakeValue(std::move(result));
  }
}

} // namespace isosurface

#endif
