// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/StoredField.h"

#include "Ranks/Query/SurfaceMemory.h"

#include <algorithm>
#include <utility>

namespace isosurface
{

void StoredField::Ask(const ExtractionTask& task, const ExtractionBudget& budget)
{
  this->Same = this->Task.Query.TimeStep == task.Query.TimeStep && this->GetVolume() == task.Volume;
  this->Volume = task.Volume;
  this->Task = task;
  this->Task.Volume = nullptr;
  this->Budget = budget;
}

ExtractionTask StoredField::MakeTask() const
{
  ExtractionTask task = this->Task;
  task.Volume = this->GetVolume();
  return task;
}

//------------------------------------------------------------------------------
// Levels

int StoredField::FindFinestLevel(int level) const
{
  return std::min(level, this->GetVolume()->GetNumberOfLevels() - 1);
}

Result<Field::First> StoredField::FindFirst(
  Communicator&, const std::vector<std::uint64_t>&, int finest)
{
  const BlockedVolume& volume = *this->GetVolume();
  ISOSURFACE_ASSIGN_OR_RETURN(const double all, this->EstimateTriangles(finest));
  const double most = std::min(FirstSurfaceTriangles, FirstSurfaceShare * all);
  First first{ finest };
  double triangles = all;
  for (int level = finest + 1; triangles > most && level < volume.GetNumberOfLevels(); ++level)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(triangles, this->EstimateTriangles(level));
    first.Level = triangles > 0 ? level : first.Level;
  }
  const double direct =
    volume.GetHeader().IsInPlace() ? DirectSurfaceTrianglesInPlace : DirectSurfaceTriangles;
  first.IsDirect = all <= direct;
  return first;
}

int StoredField::GetNextLevel(int level, int finest) const
{
  return std::max(finest, this->GetVolume()->GetSpectrumLevel(level - 1));
}

Result<LevelChoice> StoredField::ChooseLevel(
  Communicator& ranks, int finest, const ExtractionBudget& budget, QueryStatistics& statistics)
{
  return isosurface::ChooseLevel(
    *this->GetVolume(), this->Task.Query, finest, budget, this->Rate, ranks, statistics);
}

Result<int> StoredField::FitLevel(Communicator& ranks, int level)
{
  if (!this->Budget.IsLimited())
  {
    return level;
  }
  QueryStatistics statistics;
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto within, this->ChooseLevel(ranks, level, this->Budget, statistics));
  return within.Level;
}

Result<double> StoredField::EstimateTriangles(int level)
{
  return isosurface::EstimateTriangles(*this->GetVolume(), this->Task.Query, level);
}

double StoredField::EstimateBytes(double triangles) const
{
  return EstimateBytesPerTriangle(this->Task.Request) / this->Task.Query.Ranks * triangles;
}

//------------------------------------------------------------------------------
// Surfaces

Status StoredField::Extract(Communicator& ranks, int level, ExtractionOutcome& outcome)
{
  return this->Budget.IsLimited() ? this->ExtractWithinBudget(ranks, level, outcome)
                                  : this->Take(level, 0, ExtractLevel, outcome);
}

Status StoredField::ExtractAtLevel(const LevelChoice& choice, ExtractionOutcome& outcome)
{
  ISOSURFACE_RETURN_IF_ERROR(this->Take(choice.Level, 0, ExtractLevel, outcome));
  ExtractionWork work = choice.Work;
  if (work.Blocks > 0)
  {
    if (this->Task.Sharing)
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

Status StoredField::Probe(Communicator& ranks, int finest, QueryStatistics& reading)
{
  this->HasProbed = true;
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto probe, this->ChooseLevel(ranks, finest, { this->Budget.Seconds / 10, 0 }, reading));
  ExtractionOutcome unused;
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(this->ExtractAtLevel(probe, unused)));
  reading.Add(unused.Cost.Reading);
  return Status::Ok();
}

Status StoredField::ExtractWithinBudget(Communicator& ranks, int finest, ExtractionOutcome& outcome)
{
  QueryStatistics& reading = outcome.Cost.Reading;
  // A rank that has had no active blocks knows nothing yet, so that all have to agree.
  const bool isUnknown = ranks.Any(!this->Rate.IsKnown());
  if (this->Budget.Seconds > 0 && isUnknown && !this->HasProbed)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Probe(ranks, finest, reading));
  }
  const int coarsest = this->GetVolume()->GetNumberOfLevels() - 1;
  LevelLimit missed = LevelLimit::None;
  while (true)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto choice, this->ChooseLevel(ranks, finest, this->Budget, reading));
    choice.Limit = missed != LevelLimit::None ? missed : choice.Limit;
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(this->ExtractAtLevel(choice, outcome)));
    outcome.Cost.Choice = choice;
    const std::uint64_t triangles = ranks.Sum(outcome.Extracted.NumberOfTriangles);
    if (this->Budget.Triangles == 0 || triangles <= this->Budget.Triangles ||
      choice.Level == coarsest)
    {
      return Status::Ok();
    }
    // The estimate was too low.
    finest = choice.Level + 1;
    missed = LevelLimit::Triangles;
  }
}

//------------------------------------------------------------------------------
// The prepared surface

StoredField::Key StoredField::MakeKey(const ExtractionTask& task, int level, std::int64_t variant)
{
  return { level, task.Query.Rank, task.Query.Ranks, variant,
    static_cast<std::int64_t>(task.Volume->GetFaultEpoch()) };
}

Status StoredField::Take(
  int level, std::int64_t variant, const Extraction& extract, ExtractionOutcome& outcome)
{
  const ExtractionTask task = this->MakeTask();
  const bool isMine = this->Prepared && this->PreparedKey == MakeKey(task, level, variant);
  // Prepared surfaces are of the ranks' own shares, so either all are taken or none.
  if (!(task.Sharing ? task.Sharing->All(isMine) : isMine))
  {
    return extract(task, level, outcome);
  }
  SerialCommunicator alone;
  const auto prepared = std::move(this->Prepared);
  return prepared->Take(alone, task.Advance, outcome);
}

Status StoredField::Prepare(Communicator&, int level)
{
  return this->PrepareVariant(level, 0, ExtractLevel);
}

Status StoredField::PrepareVariant(int level, std::int64_t variant, Extraction extract)
{
  return Attempt("the next surface cannot be prepared",
    [&]
    {
      this->DropPrepared();
      this->Dropped.reset();
      ExtractionTask task = this->MakeTask();
      this->PreparedKey = MakeKey(task, level, variant);
      task.Sharing = nullptr;
      SerialCommunicator alone;
      this->Prepared = std::make_unique<BackgroundExtraction>(alone,
        [task = std::move(task), level, extract = std::move(extract)](
          Communicator&, const Progress& advance, ExtractionOutcome& outcome) mutable
        {
          task.Advance = advance;
          return extract(task, level, outcome);
        });
      return Status::Ok();
    });
}

CollectiveTask* StoredField::GetPrepared()
{
  return this->Prepared ? &this->Prepared->GetWork() : nullptr;
}

void StoredField::DropPrepared()
{
  if (this->Prepared)
  {
    this->Prepared->GetWork().Stop();
    this->Dropped = std::move(this->Prepared);
  }
}

} // namespace isosurface
