// SPDX-License-Identifier: BSD-3-Clause
#include "Interface/Call.h"

#include "Ground/Base/ReadingStop.h"
#include "Interface/CallbackRanks.h"

#include <atomic>
#include <utility>

#include <pthread.h>

namespace isosurface
{
namespace
{

constexpr std::chrono::milliseconds TimeBetweenLooks{ 100 };

std::atomic<int> Workers{ 0 }; ///< calls at work
std::atomic<bool> IsForkedAtWork{ false };

/// Has a process that is forked while a thread is at work refuse work, since what that thread held it holds for ever.
const int ForksAreWatched =
  ::pthread_atfork(nullptr, nullptr, [] { IsForkedAtWork = Workers > 0; });

/// The message of the last error of the calling thread.
std::string& GetMessage()
{
  static thread_local std::string message;
  return message;
}

struct Worker
{
  Worker() { ++Workers; }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() { --Workers; }
};

Status RunHere(
  const std::string& context, const si_run* run, const std::function<Status(Call&)>& work)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto taken, TakeStructure(run, "si_run"));
  ISOSURFACE_RETURN_IF_ERROR(CallbackRanks::Check(taken.ranks));
  const Worker counted;
  Call call(taken);
  const ReadingStop stop(call.GetProgress());
  Status status = Attempt(context, [&] { return work(call); });
  return status.IsOk() && call.IsStopped()
    ? Status(StatusCode::Aborted, context + ": a callback has stopped it")
    : status;
}

} // namespace

Call::Call(const si_run& run)
  : Run(run)
  , Ranks(CallbackRanks::Make(run.ranks))
  , Advance([this](double done) { return this->Look(done); })
{
}

bool Call::Look(double done)
{
  const auto now = std::chrono::steady_clock::now();
  if (this->Run.progress && !this->Stopped && now - this->LastLook >= TimeBetweenLooks)
  {
    this->LastLook = now;
    this->Stopped = this->Run.progress(done, this->Run.context) != 0;
  }
  return !this->Stopped;
}

void Call::Warn(const std::string& message)
{
  if (this->Run.warn && !this->Stopped && !message.empty())
  {
    this->Stopped = this->Run.warn(message.c_str(), this->Run.context) != 0;
  }
}

si_result EndCall(const Status& status)
{
  if (!status.IsOk())
  {
    GetMessage() = status.GetMessage();
  }
  return static_cast<si_result>(status.GetCode());
}

si_result RunCall(
  const std::string& context, const si_run* run, const std::function<Status(Call&)>& work)
{
  static_cast<void>(ForksAreWatched);
  if (IsForkedAtWork)
  {
    GetMessage() =
      "this process was forked while another thread read or wrote; start processes by 'spawn', or "
      "before there are threads";
    return SI_FORKED;
  }
  return EndCall(Attempt(context, [&] { return RunHere(context, run, work); }));
}

} // namespace isosurface

static_assert(static_cast<int>(isosurface::StatusCode::RemoteFailure) == SI_REMOTE_FAILURE &&
  static_cast<int>(isosurface::StatusCode::Corrupt) == SI_CORRUPT);

int32_t si_version(void)
{
  return SI_VERSION;
}

const char* si_error(void)
{
  return isosurface::GetMessage().c_str();
}
