// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/LevelExtraction.h"

#include "Ground/Base/Stopwatch.h"
#include "Ground/Base/WithinMemory.h"
#include "Ranks/Sharing/QueryPlan.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Surface/Contour/SlicedBlocks.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Contour/SurfaceMerge.h"

#include <cmath>
#include <cstddef>
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
  source.SetOwnBlocks(plan.GetOwnBegin(), plan.GetOwnEnd());
  ContourRequest request = task.Request;
  request.Lines = volume.GetLines(level);
  const GridGeometry geometry = volume.GetHeader().Grid.Coarsen(level);
  const auto extract = [&]
  {
    if (!counters)
    {
      return ExtractSurface(geometry, source, request, task.Threads, task.Advance);
    }
    BlockClaims claims(*counters, query.Rank, std::move(plan.Firsts), task.Threads,
      [&source](std::size_t begin, std::size_t end) { source.ReadOthersAhead(begin, end); });
    return ExtractQueuedSurface(geometry, source, request, claims, task.Threads, task.Advance);
  };
  auto extracted = extract();
  reading.Add(source.GetStatistics());
  ISOSURFACE_RETURN_IF_ERROR(NameVolume(volume, extracted.GetStatus()));
  outcome.Extracted = std::move(*extracted);
  reading.ActiveBlocks = outcome.Extracted.NumberOfBlocks;
  return Status::Ok();
}

/// Where the slices of vertices of a grid are on its third axis.
double FindPlace(const GridGeometry& grid, const GridLines* lines, std::int64_t slice)
{
  if (lines)
  {
    return lines->At(2, slice);
  }
  double place = grid.Spacing[2] * static_cast<double>(grid.Extent[4] + slice);
  for (std::size_t row = 0; row < 3; ++row)
  {
    place += grid.Direction[3 * row + 2] * grid.Origin[row];
  }
  return place;
}

/// Where a surface changes from the finished layers to a sample.
struct Seam
{
  std::int64_t Finished = 0; ///< slices of cells that are taken of the finished layers
  std::int64_t Sample = 0;   ///< the first slice of vertices that is taken of the sample
};

/// The last slice of the sample that lies in the finished ones; these are cut there, too. If the
/// sample ends within them, nothing of it is taken; if it begins behind them, all.
Seam FindSeam(const BlockedVolumeHeader& volume, std::int64_t finished, const GridGeometry& sample,
  const GridLines* sampleLines)
{
  const GridLines* const lines = volume.Lines ? &*volume.Lines : nullptr;
  const double sign = !lines && volume.Grid.Spacing[2] < 0 ? -1 : 1;
  const auto isBehind = [&](std::int64_t slice, std::int64_t of)
  {
    return sign * FindPlace(sample, sampleLines, slice) >
      sign * FindPlace(volume.Grid, lines, of) + 1e-6 * std::abs(volume.Grid.Spacing[2]);
  };
  const std::int64_t last = sample.GetDimensions()[2] - 1;
  Seam seam{ finished, 0 };
  while (seam.Sample < last && !isBehind(seam.Sample + 1, finished))
  {
    ++seam.Sample;
  }
  while (seam.Sample < last && seam.Finished > 0 && !isBehind(seam.Sample, seam.Finished - 1))
  {
    --seam.Finished;
  }
  return seam;
}

/// The finished layers exactly, and the sample behind them.
Status ExtractFinished(const ExtractionTask& task, int level, ExtractionOutcome& outcome)
{
  BlockedVolume& volume = *task.Volume;
  const BlockedVolumeHeader& finished = task.Finished->GetHeader();
  const GridGeometry geometry = volume.GetHeader().Grid.Coarsen(level);
  const Seam seam = FindSeam(finished, task.FinishedSlices, geometry, volume.GetLines(level));
  ISOSURFACE_ASSIGN_OR_RETURN(auto blocks,
    task.Finished->FindBlocks(task.Query, task.Query.Attributes, seam.Finished,
      static_cast<std::size_t>(task.Query.Rank), static_cast<std::size_t>(task.Query.Ranks)));
  SlicedBlocks exactBlocks(*blocks, 0, seam.Finished);
  ContourRequest request = task.Request;
  request.Lines = finished.Lines ? &*finished.Lines : nullptr;
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto exact, ExtractSurface(finished.Grid, exactBlocks, request, task.Threads, task.Advance));
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto plan, PlanQuery(volume, task.Query, level, outcome.Cost.Reading));
  StoredBlockSource source(
    volume, task.Query.TimeStep, task.Query.Variable, level, std::move(plan.Blocks));
  source.SetAttributes(task.Query.Attributes);
  SlicedBlocks sampleBlocks(source, seam.Sample, geometry.GetDimensions()[2] - 1);
  request.Lines = volume.GetLines(level);
  auto sample = ExtractSurface(geometry, sampleBlocks, request, task.Threads,
    [&](double) { return !task.Advance || task.Advance(1); });
  outcome.Cost.Reading.Add(source.GetStatistics());
  ISOSURFACE_RETURN_IF_ERROR(sample.GetStatus());
  ShiftGlobalIds(CountGlobalIds(finished.Grid, task.Request), *sample);
  std::vector<Surface> surfaces;
  surfaces.push_back(std::move(exact));
  surfaces.push_back(std::move(*sample));
  outcome.Extracted = JoinSurfaces(surfaces);
  outcome.Cost.Reading.ActiveBlocks = outcome.Extracted.NumberOfBlocks;
  return Status::Ok();
}

} // namespace

Status ExtractLevel(const ExtractionTask& task, int level, ExtractionOutcome& outcome)
{
  const auto counters = task.Sharing && task.FinishedSlices == 0
    ? MakeClaimCounters(*task.Sharing, *task.Volume, task.Query)
    : nullptr;
  outcome.Cost.Level = level;
  outcome.Cost.Reading.ActiveBlocks = 0;
  outcome.Seconds = 0;
  const Stopwatch stopwatch(outcome.Seconds);
  const Status status =
    RunWithinMemory(task.Volume->GetPath(), ": there is not enough memory for the isosurface",
      [&]
      {
        return task.FinishedSlices > 0 ? ExtractFinished(task, level, outcome)
                                       : ExtractPlanned(task, level, counters.get(), outcome);
      });
  if (counters && !status.IsOk())
  {
    BlockClaims::Withdraw(*counters, task.Query.Rank);
  }
  return status;
}

} // namespace isosurface
