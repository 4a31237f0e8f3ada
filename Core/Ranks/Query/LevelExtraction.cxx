// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/LevelExtraction.h"

#include "Ground/Base/Stopwatch.h"
#include "Ground/Base/WithinMemory.h"
#include "Ranks/Sharing/QueryPlan.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <cstddef>
#include <string>
#include <utility>

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

/// `counters`: of the blocks that ranks claim; null if each extracts its share.
Status ExtractPlanned(
  const ExtractionTask& task, int level, SharedCounters* counters, ExtractionOutcome& outcome)
{
  BlockedVolume& volume = *task.Volume;
  const SurfaceQuery& query = task.Query;
  QueryStatistics& reading = outcome.Cost.Reading;
  ISOSURFACE_ASSIGN_OR_RETURN(auto plan,
    PlanQuery(volume, query, level, reading, counters ? PlannedShares::All : PlannedShares::Own));
  StoredBlockSource source(volume, query.TimeStep, query.Variable, level, std::move(plan.Blocks));
  source.SetAttributes(query.Attributes);
  source.SetPart(query.Selection.Part);
  source.SetOwnBlocks(plan.GetOwnBegin(), plan.GetOwnEnd());
  ContourRequest request = task.Request;
  request.Lines = volume.GetLines(level);
  const GridGeometry geometry = volume.GetHeader().Grid.Coarsen(level);
  const int threads = volume.ChooseThreads(query.TimeStep, task.Threads);
  const auto extract = [&]
  {
    if (!counters)
    {
      return ExtractSurface(geometry, source, request, threads, task.Advance);
    }
    BlockClaims claims(*counters, query.Rank, std::move(plan.Firsts), threads,
      [&source](std::size_t begin, std::size_t end) { source.ReadOthersAhead(begin, end); });
    return ExtractQueuedSurface(geometry, source, request, claims, threads, task.Advance);
  };
  auto extracted = extract();
  reading.Add(source.GetStatistics());
  ISOSURFACE_RETURN_IF_ERROR(NameVolume(volume, extracted.GetStatus()));
  outcome.Extracted = std::move(*extracted);
  reading.ActiveBlocks = outcome.Extracted.NumberOfBlocks;
  return Status::Ok();
}

} // namespace

Status RunExtraction(const ExtractionTask& task, int level, ExtractionOutcome& outcome,
  const std::function<Status()>& extract)
{
  outcome.Cost.Level = level;
  outcome.Cost.Reading.ActiveBlocks = 0;
  outcome.Seconds = 0;
  const Stopwatch stopwatch(outcome.Seconds);
  return RunWithinMemory(
    task.Volume->GetPath(), ": there is not enough memory for the isosurface", extract);
}

Status ExtractLevel(const ExtractionTask& task, int level, ExtractionOutcome& outcome)
{
  const auto counters =
    task.Sharing ? MakeClaimCounters(*task.Sharing, *task.Volume, task.Query) : nullptr;
  const Status status = RunExtraction(
    task, level, outcome, [&] { return ExtractPlanned(task, level, counters.get(), outcome); });
  if (counters && !status.IsOk())
  {
    BlockClaims::Withdraw(*counters, task.Query.Rank);
  }
  return status;
}

Status ChooseIslands(Communicator& ranks, const Status& extracted,
  const std::optional<IslandRequest>& islands, const std::function<IslandGrids()>& makeGrids,
  int threads, ExtractionOutcome& outcome)
{
  outcome.ExtractedTriangles = outcome.Extracted.NumberOfTriangles;
  if (!islands)
  {
    return extracted;
  }
  IslandRequest request = *islands;
  request.Level = outcome.Cost.Level;
  const Stopwatch stopwatch(outcome.IslandSeconds);
  return ChooseIslands(
    ranks, extracted, request, makeGrids, threads, outcome.Extracted, outcome.Islands);
}

IslandGrids MakeIslandGrids(const ExtractionTask& task, int level, const Communicator& ranks)
{
  BlockedVolume& volume = *task.Volume;
  const StoredLevel stored = volume.FindLevel(level);
  const GridGeometry grid = volume.GetHeader().Grid.Coarsen(level);
  IslandGrids grids;
  grids.Bounds = TriangleBounds::Of(grid, volume.GetLines(level));
  grids.Shared.emplace_back(grid, task.Request);
  if (ranks.GetSize() > 1)
  {
    grids.Shared.back().AddFacesOfBlocks(stored.Grid->GetBlockSize() >> stored.Level);
  }
  return grids;
}

} // namespace isosurface
