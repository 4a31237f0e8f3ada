// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ReadingStop_h
#define isosurface_ReadingStop_h

#include "Ground/Base/Progress.h"

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <utility>

namespace isosurface
{

/// While it lives, reads of the calling thread from files of the local file system, and from addresses, are Aborted
/// when `progress`, which they call with 0, returns false. So work stops that decodes much of a file before it can
/// tell its progress, as a gzip stream that is read from its end, or that waits for a server.
class ReadingStop
{
public:
  /// What threads that work for another one share with it.
  struct Token
  {
    std::atomic<bool> IsSet{ false };
    std::shared_ptr<Token> Outer;
  };

  /// `progress` must outlive this object.
  explicit ReadingStop(const Progress& progress)
    : Asked(&progress)
    , Before(Current)
  {
    this->Mine->Outer = Share();
    Current = this;
  }
  /// Of a thread that works for the one that has called Share().
  explicit ReadingStop(std::shared_ptr<Token> shared)
    : Before(Current)
  {
    this->Mine->Outer = std::move(shared);
    Current = this;
  }
  ReadingStop(const ReadingStop&) = delete;
  ReadingStop& operator=(const ReadingStop&) = delete;
  ~ReadingStop() { Current = this->Before; }

  /// For threads that work for the calling one: they stop when this one is asked IsWanted() and is to stop. Null if
  /// nothing stops it.
  static std::shared_ptr<Token> Share() { return Current ? Current->Mine : nullptr; }

  static bool IsWanted()
  {
    for (const ReadingStop* stop = Current; stop; stop = stop->Before)
    {
      if (stop->Asked && *stop->Asked && !(*stop->Asked)(0))
      {
        stop->Mine->IsSet = true;
      }
    }
    const Token* token = Current ? Current->Mine.get() : nullptr;
    while (token && !token->IsSet)
    {
      token = token->Outer.get();
    }
    return token != nullptr;
  }

  /// Waits for what another thread does; meanwhile this one is asked.
  template <typename Future>
  static void WaitFor(const Future& future)
  {
    constexpr std::chrono::milliseconds pause{ 100 };
    while (Current && future.wait_for(pause) == std::future_status::timeout)
    {
      static_cast<void>(IsWanted());
    }
  }

private:
  static thread_local const ReadingStop* Current;
  const std::shared_ptr<Token> Mine = std::make_shared<Token>();
  const Progress* Asked = nullptr;
  const ReadingStop* Before;
};

} // namespace isosurface

#endif
