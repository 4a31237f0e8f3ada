// SPDX-License-Identifier: BSD-3-Clause
#include "Query/LevelExtraction.h"

#include "Contour/SurfaceExtractor.h"
#include "Query/StoredBlockSource.h"

#include <chrono>
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

} // namespace

Status ExtractLevel(const ExtractionTask& task, int level, ExtractionOutcome& outcome)
{
  const auto start = std::chrono::steady_clock::now();
  const SurfaceQuery& query = task.Query;
  outcome.Cost.Level = level;
  QueryStatistics& reading = outcome.Cost.Reading;
  reading.ActiveBlocks = 0;
  auto active = task.Volume.FindActiveBlocks(query.TimeStep, query.Variable, query.Isovalues,
    query.Rank, query.Ranks, reading, level, query.Selection);
  ISOSURFACE_RETURN_IF_ERROR(active.GetStatus());
  StoredBlockSource source(task.Volume, query.TimeStep, query.Variable, level, std::move(*active));
  source.SetAttributes(query.Attributes);
  ContourRequest request = task.Request;
  request.Lines = task.Volume.GetLines(level);
  auto extracted = ExtractSurface(
    task.Volume.GetHeader().Grid.Coarsen(level), source, request, task.Threads, task.Advance);
  reading.Add(source.GetStatistics());
  ISOSURFACE_RETURN_IF_ERROR(NameVolume(task.Volume, extracted.GetStatus()));
  outcome.Extracted = std::move(*extracted);
  outcome.Seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return Status::Ok();
}

} // namespace isosurface
