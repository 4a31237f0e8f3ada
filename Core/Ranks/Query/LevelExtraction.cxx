// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/LevelExtraction.h"

#include "Ranks/Query/BlockClaims.h"
#include "Ranks/Query/StoredBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <chrono>
#include <memory>
#include <new>
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

/// Extracts the blocks of a source, or those of them that a queue hands out.
Status ExtractBlocks(const ExtractionTask& task, int level, StoredBlockSource& source,
  BlockQueue* queue, ExtractionOutcome& outcome)
{
  source.SetAttributes(task.Query.Attributes);
  ContourRequest request = task.Request;
  request.Lines = task.Volume.GetLines(level);
  const GridGeometry geometry = task.Volume.GetHeader().Grid.Coarsen(level);
  auto extracted = queue
    ? ExtractQueuedSurface(geometry, source, request, *queue, task.Threads, task.Advance)
    : ExtractSurface(geometry, source, request, task.Threads, task.Advance);
  outcome.Cost.Reading.Add(source.GetStatistics());
  ISOSURFACE_RETURN_IF_ERROR(NameVolume(task.Volume, extracted.GetStatus()));
  outcome.Extracted = std::move(*extracted);
  return Status::Ok();
}

Status ExtractShare(const ExtractionTask& task, int level, ExtractionOutcome& outcome)
{
  const SurfaceQuery& query = task.Query;
  auto active = task.Volume.FindActiveBlocks(query.TimeStep, query.Variable, query.Isovalues,
    query.Rank, query.Ranks, outcome.Cost.Reading, level, query.Selection);
  ISOSURFACE_RETURN_IF_ERROR(active.GetStatus());
  StoredBlockSource source(task.Volume, query.TimeStep, query.Variable, level, std::move(*active));
  return ExtractBlocks(task, level, source, nullptr, outcome);
}

Status ExtractClaims(
  const ExtractionTask& task, int level, SharedCounters& counters, ExtractionOutcome& outcome)
{
  const SurfaceQuery& query = task.Query;
  auto shares = task.Volume.FindActiveShares(query.TimeStep, query.Variable, query.Isovalues,
    query.Rank, query.Ranks, outcome.Cost.Reading, level, query.Selection);
  ISOSURFACE_RETURN_IF_ERROR(shares.GetStatus());
  std::vector<BlockReference> blocks;
  std::vector<std::size_t> firsts = { 0 };
  for (const std::vector<BlockReference>& share : *shares)
  {
    blocks.insert(blocks.end(), share.begin(), share.end());
    firsts.push_back(blocks.size());
  }
  shares->clear();
  StoredBlockSource source(task.Volume, query.TimeStep, query.Variable, level, std::move(blocks));
  const auto own = static_cast<std::size_t>(query.Rank);
  source.SetOwnBlocks(firsts[own], firsts[own + 1]);
  BlockClaims claims(counters, query.Rank, std::move(firsts), task.Threads,
    [&source](std::size_t begin, std::size_t end) { source.ReadOthersAhead(begin, end); });
  const Status status = ExtractBlocks(task, level, source, &claims, outcome);
  outcome.Cost.Reading.ActiveBlocks = status.IsOk() ? outcome.Extracted.NumberOfBlocks : 0;
  return status;
}

/// The counters by which ranks claim blocks; null on all ranks if one cannot share its blocks.
std::unique_ptr<SharedCounters> MakeCounters(const ExtractionTask& task)
{
  if (!task.Sharing || task.Sharing->GetSize() == 1)
  {
    return nullptr;
  }
  const bool canShare = task.Volume.DealsBlocks() && task.Query.Rank == task.Sharing->GetRank() &&
    task.Query.Ranks == task.Sharing->GetSize();
  return task.Sharing->MakeCounters(canShare);
}

} // namespace

Status ExtractLevel(const ExtractionTask& task, int level, ExtractionOutcome& outcome)
{
  const std::unique_ptr<SharedCounters> counters = MakeCounters(task);
  const auto start = std::chrono::steady_clock::now();
  outcome.Cost.Level = level;
  outcome.Cost.Reading.ActiveBlocks = 0;
  Status status;
  if (!counters)
  {
    status = ExtractShare(task, level, outcome);
  }
  else
  {
    try
    {
      status = ExtractClaims(task, level, *counters, outcome);
    }
    catch (const std::bad_alloc&)
    {
      status = Status(StatusCode::OutOfMemory,
        task.Volume.GetPath() + ": there is not enough memory for the isosurface");
    }
    if (!status.IsOk())
    {
      BlockClaims::Withdraw(*counters, task.Query.Rank);
    }
  }
  outcome.Seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return status;
}

} // namespace isosurface
