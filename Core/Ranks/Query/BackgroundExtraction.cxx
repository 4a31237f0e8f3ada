// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/BackgroundExtraction.h"

#include "Ground/Base/ThreadPriority.h"

#include <chrono>
#include <utility>

namespace isosurface
{
namespace
{

constexpr double PollSeconds = 0.02;

} // namespace

BackgroundExtraction::BackgroundExtraction(ExtractionTask task, int level)
  : Task(std::move(task))
  , Level(level)
  , Thread([this] { this->Run(); })
{
}

BackgroundExtraction::~BackgroundExtraction()
{
  this->Stop();
  this->Thread.join();
}

void BackgroundExtraction::Run()
{
  LowerThreadPriority();
  ExtractionTask task = this->Task;
  task.Sharing = nullptr;
  task.Advance = [this](double fraction)
  {
    this->Done = fraction;
    return !this->Stopped;
  };
  this->EndStatus = Attempt("the isosurface cannot be extracted",
    [&] { return ExtractLevel(task, this->Level, this->Outcome); });
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->HasEnded = true;
  this->Ended.notify_all();
}

bool BackgroundExtraction::Wait(double seconds)
{
  std::unique_lock<std::mutex> lock(this->Mutex);
  return this->Ended.wait_for(
    lock, std::chrono::duration<double>(seconds), [this] { return this->HasEnded; });
}

Status BackgroundExtraction::Take(const Progress& advance, ExtractionOutcome& outcome)
{
  while (!this->Wait(PollSeconds))
  {
    if (advance && !advance(this->Done))
    {
      return { StatusCode::Aborted, "The extraction was aborted." };
    }
  }
  QueryStatistics reading = outcome.Cost.Reading;
  reading.ActiveBlocks = 0;
  reading.Add(this->Outcome.Cost.Reading);
  ISOSURFACE_RETURN_IF_ERROR(this->EndStatus);
  outcome = std::move(this->Outcome);
  outcome.Cost.Reading = reading;
  return Status::Ok();
}

} // namespace isosurface
