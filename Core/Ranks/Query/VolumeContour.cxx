// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/VolumeContour.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace isosurface
{

Status VolumeContour::ExtractAtLevel(
  const ExtractionTask& task, const LevelChoice& choice, ExtractionOutcome& outcome)
{
  if (this->IsPrepared(task, choice.Level))
  {
    SerialCommunicator alone;
    const Status status = this->Prepared->Take(alone, task.Advance, outcome);
    this->Prepared.reset();
    ISOSURFACE_RETURN_IF_ERROR(status);
  }
  else
  {
    ISOSURFACE_RETURN_IF_ERROR(ExtractLevel(task, choice.Level, outcome));
  }
  if (choice.Work.Blocks > 0)
  {
    ExtractionWork work = choice.Work;
    if (task.Sharing)
    {
      // Other blocks than were expected, and other numbers of them.
      const double part = static_cast<double>(outcome.Extracted.NumberOfBlocks) / work.Blocks;
      work.Blocks *= part;
      work.SampleBytes *= part;
      work.BlocksRead *= part;
      work.ReadBytes *= part;
    }
    work.Triangles = static_cast<double>(outcome.Extracted.NumberOfTriangles);
    this->Rate.Observe(work, outcome.Seconds);
  }
  return Status::Ok();
}

VolumeContour::Key VolumeContour::MakeKey(const ExtractionTask& task, int level)
{
  return { static_cast<std::uint64_t>(level), static_cast<std::uint64_t>(task.Query.Rank),
    static_cast<std::uint64_t>(task.Query.Ranks), static_cast<std::uint64_t>(task.FinishedSlices),
    task.Volume->GetFaultEpoch() };
}

bool VolumeContour::IsPrepared(const ExtractionTask& task, int level) const
{
  const bool isMine = this->Prepared && this->PreparedKey == MakeKey(task, level);
  if (!task.Sharing)
  {
    return isMine;
  }
  // Prepared surfaces are of the ranks' own shares, so either all are taken or none.
  return task.Sharing->All(isMine);
}

void VolumeContour::Prepare(ExtractionTask task, int level)
{
  this->DropPrepared();
  this->Dropped.reset();
  this->PreparedKey = MakeKey(task, level);
  task.Sharing = nullptr;
  SerialCommunicator alone;
  this->Prepared = std::make_unique<BackgroundExtraction>(alone,
    [task = std::move(task), level](
      Communicator&, const Progress& advance, ExtractionOutcome& outcome) mutable
    {
      task.Advance = advance;
      return ExtractLevel(task, level, outcome);
    });
}

void VolumeContour::DropPrepared()
{
  if (this->Prepared)
  {
    this->Prepared->GetWork().Stop();
    this->Dropped = std::move(this->Prepared);
  }
}

Status VolumeContour::ExtractWithinBudget(Communicator& ranks, const ExtractionBudget& budget,
  const ExtractionTask& task, int finest, ExtractionOutcome& outcome)
{
  QueryStatistics& reading = outcome.Cost.Reading;
  // A rank that has had no active blocks knows nothing yet, so that all have to agree.
  const bool isUnknown = ranks.Any(!this->Rate.IsKnown());
  if (budget.Seconds > 0 && isUnknown && !this->HasProbed)
  {
    this->HasProbed = true;
    // A coarse level costs little, and shows the speed of this machine.
    ISOSURFACE_ASSIGN_OR_RETURN(const auto probe,
      ChooseLevel(
        *task.Volume, task.Query, finest, { budget.Seconds / 10, 0 }, this->Rate, ranks, reading));
    ExtractionOutcome unused;
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(this->ExtractAtLevel(task, probe, unused)));
    reading.Add(unused.Cost.Reading);
  }
  auto choice = ChooseLevel(*task.Volume, task.Query, finest, budget, this->Rate, ranks, reading);
  ISOSURFACE_RETURN_IF_ERROR(choice.GetStatus());
  const int coarsest = task.Volume->GetNumberOfLevels() - 1;
  while (true)
  {
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(this->ExtractAtLevel(task, *choice, outcome)));
    outcome.Cost.Choice = *choice;
    const std::uint64_t triangles = ranks.Sum(outcome.Extracted.NumberOfTriangles);
    if (budget.Triangles == 0 || triangles <= budget.Triangles || choice->Level == coarsest)
    {
      return Status::Ok();
    }
    // The estimate was too low.
    choice =
      ChooseLevel(*task.Volume, task.Query, choice->Level + 1, budget, this->Rate, ranks, reading);
    ISOSURFACE_RETURN_IF_ERROR(choice.GetStatus());
    choice->Limit = LevelLimit::Triangles;
  }
}

} // namespace isosurface
