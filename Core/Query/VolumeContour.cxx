// SPDX-License-Identifier: BSD-3-Clause
#include "Query/VolumeContour.h"

#include "Query/StoredBlockSource.h"

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/// An error of the extraction itself does not know what file its blocks are from.
Status NameVolume(const BlockedVolume& volume, const Status& status)
{
  const bool isNamed = status.IsOk() || status.GetCode() == StatusCode::Aborted ||
    status.GetMessage().find(volume.GetPath()) != std::string::npos;
  return isNamed ? status : Status(status.GetCode(), volume.GetPath() + ": " + status.GetMessage());
}

} // namespace

Status VolumeContour::ExtractAtLevel(const Task& task, const LevelChoice& choice, Outcome& outcome)
{
  const auto start = std::chrono::steady_clock::now();
  const SurfaceQuery& query = task.Query;
  outcome.Cost.Level = choice.Level;
  QueryStatistics& reading = outcome.Cost.Reading;
  reading.ActiveBlocks = 0;
  auto active = task.Volume.FindActiveBlocks(query.TimeStep, query.Variable, query.Isovalues,
    query.Rank, query.Ranks, reading, choice.Level, query.Selection);
  ISOSURFACE_RETURN_IF_ERROR(active.GetStatus());
  StoredBlockSource source(
    task.Volume, query.TimeStep, query.Variable, choice.Level, std::move(*active));
  source.SetAttributes(query.Attributes);
  auto extracted = ExtractSurface(task.Volume.GetHeader().Grid.Coarsen(choice.Level), source,
    task.Request, task.Threads, task.Advance);
  reading.Add(source.GetStatistics());
  ISOSURFACE_RETURN_IF_ERROR(NameVolume(task.Volume, extracted.GetStatus()));
  outcome.Extracted = std::move(*extracted);
  if (choice.Work.Blocks > 0)
  {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    ExtractionWork work = choice.Work;
    work.Triangles = static_cast<double>(outcome.Extracted.NumberOfTriangles);
    this->Rate.Observe(work, seconds.count());
  }
  return Status::Ok();
}

Status VolumeContour::ExtractWithinBudget(Communicator& ranks, const ExtractionBudget& budget,
  const Task& task, int finest, Outcome& outcome)
{
  QueryStatistics& reading = outcome.Cost.Reading;
  // A rank that has had no active blocks knows nothing yet, so that all have to agree.
  std::vector<std::uint64_t> isUnknown = { this->Rate.IsKnown() ? 0U : 1U };
  ranks.ReduceMaximum(isUnknown);
  if (budget.Seconds > 0 && isUnknown.front() != 0 && !this->HasProbed)
  {
    this->HasProbed = true;
    // A coarse level costs little, and shows the speed of this machine.
    const auto probe = ChooseLevel(
      task.Volume, task.Query, finest, { budget.Seconds / 10, 0 }, this->Rate, ranks, reading);
    ISOSURFACE_RETURN_IF_ERROR(probe.GetStatus());
    Outcome unused;
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(this->ExtractAtLevel(task, *probe, unused)));
    reading.Add(unused.Cost.Reading);
  }
  auto choice = ChooseLevel(task.Volume, task.Query, finest, budget, this->Rate, ranks, reading);
  ISOSURFACE_RETURN_IF_ERROR(choice.GetStatus());
  const int coarsest = task.Volume.GetNumberOfLevels() - 1;
  while (true)
  {
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(this->ExtractAtLevel(task, *choice, outcome)));
    outcome.Cost.Choice = *choice;
    std::vector<std::uint64_t> triangles = { outcome.Extracted.NumberOfTriangles };
    ranks.ReduceSum(triangles);
    if (budget.Triangles == 0 || triangles[0] <= budget.Triangles || choice->Level == coarsest)
    {
      return Status::Ok();
    }
    // The estimate was too low.
    choice = ChooseLevel(
      task.Volume, task.Query, choice->Level + 1, budget, this->Rate, ranks, reading);
    ISOSURFACE_RETURN_IF_ERROR(choice.GetStatus());
    choice->Limit = LevelLimit::Triangles;
  }
}

} // namespace isosurface
