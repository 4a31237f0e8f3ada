// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Files/SurfaceQueries.h"

#include "Ground/Base/Communicator.h"
#include "Ranks/Query/LevelChoice.h"
#include "Ranks/Query/LevelExtraction.h"
#include "Ranks/Sharing/QueryPlan.h"
#include "Ranks/Sharing/StoreRecovery.h"

#include <string>
#include <utility>

namespace isosurface
{
namespace
{

/// What the file has of them in blocks.
struct SearchedBlocks
{
  std::shared_ptr<BlockedVolume> Volume;
  SurfaceQuery Query;
};

Result<SearchedBlocks> MakeQuery(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress)
{
  SearchedBlocks searched;
  ISOSURFACE_ASSIGN_OR_RETURN(
    searched.Volume, file.GetBlocks(samples.TimeStep, progress, searched.Query.TimeStep));
  const auto variable = searched.Volume->GetVariables().Find(samples.Array, samples.Component);
  if (!variable)
  {
    return Status(StatusCode::InvalidArgument, file.GetPath() + ": has no such component");
  }
  searched.Query.Variable = *variable;
  searched.Query.Isovalues = request.Isovalues;
  searched.Query.Attributes = request.Attributes;
  searched.Query.Selection.ClosedSides = request.ClosedSides;
  if (request.Bounds)
  {
    searched.Query.Selection.Region = Region::FromBounds(*request.Bounds);
  }
  return searched;
}

Status KeepIslands(
  const ExtractionTask& task, int level, const IslandRequest& islands, Surface& surface)
{
  const GridGeometry grid = task.Volume->GetHeader().Grid.Coarsen(level);
  const IslandGrids grids{ TriangleBounds::Of(grid, task.Volume->GetLines(level)),
    { SharedPlanes(grid, task.Request) } };
  SerialCommunicator alone;
  ChosenIslands unused;
  return ChooseIslands(alone, islands, grids, task.Threads, surface, unused);
}

/// Runs a step anew as long as it fails, and other replicas of stores are known.
template <typename Step>
Status RunAlone(BlockedVolume& volume, std::string& warning, const Step& step)
{
  SerialCommunicator alone;
  return RunWithReplicas(
    alone, [&] { return &volume; }, warning, step);
}

} // namespace

Result<Surface> ExtractSurface(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress, std::string& warning)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto searched, MakeQuery(file, samples, request, progress));
  ExtractionTask task;
  task.Volume = searched.Volume;
  task.Query = searched.Query;
  task.Request.Isovalues = request.Isovalues;
  task.Request.Normals = request.Normals;
  task.Request.NormalsRoundedOnce = true;
  task.Request.Precision = request.Precision;
  task.Request.ClosedSides = request.ClosedSides;
  task.Request.DropDegenerateTriangles = request.DropDegenerateTriangles;
  task.Request.GlobalIds = request.Islands.has_value();
  task.Threads = request.Threads;
  task.Advance = progress;
  for (const std::size_t array : request.Attributes)
  {
    const ArrayDescription& description = file.GetArrays()[array];
    task.Request.Attributes.push_back({ description.Type, description.Components });
  }
  ExtractionOutcome outcome;
  ISOSURFACE_RETURN_IF_ERROR(
    RunAlone(*task.Volume, warning, [&] { return ExtractLevel(task, samples.Level, outcome); }));
  if (request.Islands)
  {
    ISOSURFACE_RETURN_IF_ERROR(
      KeepIslands(task, samples.Level, *request.Islands, outcome.Extracted));
  }
  return std::move(outcome.Extracted);
}

Result<std::vector<VertexBox>> FindActiveBlocks(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress, std::string& warning)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto searched, MakeQuery(file, samples, request, progress));
  BlockedVolume& volume = *searched.Volume;
  const StoredLevel stored = volume.FindLevel(samples.Level);
  std::vector<VertexBox> boxes;
  const auto find = [&]() -> Status
  {
    QueryStatistics unused;
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto plan, PlanQuery(volume, searched.Query, samples.Level, unused));
    boxes.clear();
    for (const BlockReference& block : plan.Blocks)
    {
      boxes.push_back(stored.Grid->GetVertices(block.Block, stored.Level));
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(RunAlone(volume, warning, find));
  return boxes;
}

Result<double> EstimateTriangles(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto searched, MakeQuery(file, samples, request, progress));
  return EstimateTriangles(*searched.Volume, searched.Query, samples.Level);
}

Result<std::shared_ptr<const WorkloadSpectrum>> ReadSpectrum(
  VolumeFile& file, const ContouredSamples& samples, const Progress& progress)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto searched, MakeQuery(file, samples, {}, progress));
  return searched.Volume->GetSpectrum(
    searched.Query.TimeStep, searched.Query.Variable, samples.Level);
}

} // namespace isosurface
