// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/BackgroundExtraction.h"

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
  , Work("the isosurface cannot be extracted",
      [this](const Progress& advance) { return this->Extract(advance); })
{
}

Status BackgroundExtraction::Extract(const Progress& advance)
{
  ExtractionTask task = this->Task;
  task.Sharing = nullptr;
  task.Advance = advance;
  return ExtractLevel(task, this->Level, this->Outcome);
}

Status BackgroundExtraction::Take(const Progress& advance, ExtractionOutcome& outcome)
{
  while (!this->Wait(PollSeconds))
  {
    if (advance && !advance(this->GetProgress()))
    {
      return { StatusCode::Aborted, "The extraction was aborted." };
    }
  }
  QueryStatistics reading = outcome.Cost.Reading;
  reading.ActiveBlocks = 0;
  reading.Add(this->Outcome.Cost.Reading);
  ISOSURFACE_RETURN_IF_ERROR(this->Work.GetStatus());
  outcome = std::move(this->Outcome);
  outcome.Cost.Reading = reading;
  return Status::Ok();
}

} // namespace isosurface
