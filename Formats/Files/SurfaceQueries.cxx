// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Files/SurfaceQueries.h"

#include "Ground/Base/OutputCheck.h"
#include "Ground/Volume/BlockSelection.h"
#include "Ranks/Query/StoredField.h"
#include "Ranks/Sharing/QueryPlan.h"
#include "Ranks/Sharing/StoreRecovery.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <algorithm>
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
  Index3 First{ 0, 0, 0 }; ///< the file's vertex that is the first one there
};

/// Whether an edge-index file can hold what is asked for.
Status CheckIsWritable(const SurfaceRequest& request)
{
  const bool isClosed = !request.ClosedSides.IsEmpty();
  const char* const refused = request.Polygons ? "polygons: it has triangles"
    : request.SkipNotANumber                   ? "the holes of samples that are not a number"
    : request.Islands && request.Islands->Ids
    ? "the islands of triangles: it has no arrays of these"
    : request.DropDegenerateTriangles && !isClosed
    ? "an open surface without its degenerate triangles"
    : isClosed && (request.Normals || !request.Arrays.empty())
    ? "arrays and normals of a closed surface, whose caps have none"
    : nullptr;
  return refused
    ? Status(StatusCode::InvalidArgument, std::string("an edge-index file cannot hold ") + refused)
    : Status::Ok();
}

/// The vertices of all blocks that meet a region, with their neighbours' samples if normals need them.
VertexBox FindBlocksIn(const LevelDescription& level, const Region& where, bool withNormals)
{
  const Index3 dimensions = level.Grid.GetDimensions();
  BlockSelection selection;
  selection.Region = where;
  selection.Lines = level.Lines ? &*level.Lines : nullptr;
  const std::int64_t size = BlockedVolumeSettings().BlockSize;
  VertexBox box;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    std::optional<std::int64_t> low;
    for (std::int64_t begin = 0; begin == 0 || begin < dimensions[axis] - 1; begin += size)
    {
      VertexBox layer{ {}, dimensions };
      layer.Low[axis] = begin;
      layer.High[axis] = std::min(begin + size + 1, dimensions[axis]);
      if (selection.Selects(level.Grid, layer, true))
      {
        low = low.value_or(begin);
        box.High[axis] = layer.High[axis];
      }
    }
    // Beside the volume: the first block does not meet the region, either.
    box.High[axis] = low ? box.High[axis] : std::min(size + 1, dimensions[axis]);
    box.Low[axis] = std::max<std::int64_t>(0, low.value_or(0) - (withNormals ? size : 0));
    box.High[axis] = std::min(box.High[axis] + (withNormals ? 1 : 0), dimensions[axis]);
  }
  return box;
}

/// Of a file that gives parts, one is searched that has the blocks of the whole file that meet the region; or, if it
/// `isExact`, the cells of the box that is wanted, and only these.
Result<SearchedBlocks> MakeQuery(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress, bool isExact = false)
{
  SearchedBlocks searched;
  // Of the others, what is found depends on where the volume ends.
  const bool isPart = request.ClosedSides.IsEmpty() && !request.GlobalIds && !request.Islands;
  std::size_t step = 0;
  std::optional<VertexBox> cells;
  if (isPart && !request.Where.IsEverything() && file.GivesParts())
  {
    const LevelDescription whole = file.Describe(0);
    VertexBox part;
    if (isExact && request.Bounds && !request.Budget.IsLimited())
    {
      const std::array<double, 6>& box = *request.Bounds;
      cells = whole.FindVerticesAround({ box[0], box[2], box[4] }, { box[1], box[3], box[5] });
      part = request.Normals ? cells->AddLayer(whole.Grid.GetDimensions()) : *cells;
    }
    else
    {
      part = FindBlocksIn(whole, request.Where, request.Normals);
    }
    ISOSURFACE_ASSIGN_OR_RETURN(
      searched.Volume, file.GetBlocksOf(samples.TimeStep, part, progress, step, searched.First));
    const Index3& first = searched.First;
    cells = cells ? std::optional(cells->Translate({ -first[0], -first[1], -first[2] })) : cells;
  }
  else
  {
    ISOSURFACE_ASSIGN_OR_RETURN(searched.Volume, file.GetBlocks(samples.TimeStep, progress, step));
  }
  const auto variable = searched.Volume->GetVariables().Find(samples.Array, samples.Component);
  if (!variable)
  {
    return Status(StatusCode::InvalidArgument, file.GetPath() + ": has no such component");
  }
  searched.Query = request.MakeQuery(step, *variable);
  searched.Query.Selection.Part = cells;
  return searched;
}

/// The arrays to interpolate.
std::vector<InterpolatedArray> FindArrays(const VolumeFile& file, const SurfaceRequest& request)
{
  std::vector<InterpolatedArray> arrays;
  for (const std::size_t number : request.Arrays)
  {
    const ArrayDescription& array = file.GetArrays()[number];
    arrays.push_back({ array.Name, {}, { array.Type, array.Components } });
  }
  return arrays;
}

SerialCommunicator& GetAlone()
{
  static SerialCommunicator alone;
  return alone;
}

/// MakeQuery on each rank; all agree on the error.
Result<SearchedBlocks> MakeCommonQuery(Communicator& ranks, VolumeFile& file,
  const ContouredSamples& samples, const SurfaceRequest& request, const Progress& progress,
  bool isExact = false)
{
  auto searched =
    Attempt(file.GetPath(), [&] { return MakeQuery(file, samples, request, progress, isExact); });
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(searched.GetStatus()));
  return searched;
}

} // namespace

void MatchVtk(int version, ContourRequest& request)
{
  request.NormalsRoundedOnce = version == 0 || version >= 904;
  request.NormalsByDirection = version != 0 && version < 902;
  request.WideIndices = version != 0 && version < 904;
  request.Offsets = version != 0;
}

Result<Surface> ExtractSurface(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress, std::string& warning, int* level,
  ChosenIslands* islands)
{
  Communicator& ranks = request.Ranks ? *request.Ranks : GetAlone();
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto searched, MakeCommonQuery(ranks, file, samples, request, progress, true));
  ExtractionTask task{ searched.Volume, searched.Query, request, request.Threads, progress };
  task.Request.GlobalIds = request.GlobalIds || request.Islands;
  for (const InterpolatedArray& array : FindArrays(file, request))
  {
    task.Request.Attributes.push_back(array.Layout);
  }
  ExtractionOutcome outcome;
  const auto extract = [&]
  {
    StoredField field;
    field.Ask(task, request.Budget);
    return field.Extract(ranks, samples.Level, outcome);
  };
  const Status extracted = RunWithReplicas(
    ranks, [&] { return task.Volume.get(); }, warning,
    [&] { return Attempt(file.GetPath(), extract); });
  const int found = outcome.Cost.Level;
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(ChooseIslands(
    ranks, extracted, request.Islands, [&] { return MakeIslandGrids(task, found, ranks); },
    task.Threads, outcome)));
  if (islands)
  {
    *islands = std::move(outcome.Islands);
  }
  if (level)
  {
    *level = found;
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
      boxes.push_back(
        stored.Grid->GetVertices(block.Block, stored.Level).Translate(searched.First));
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(RunWithReplicas(
    GetAlone(), [&] { return &volume; }, warning, find));
  return boxes;
}

Status WriteSurface(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const std::string& path, const BlockCoding& coding,
  const EdgeIndexWriteJob::Settings& settings, const Progress& progress)
{
  Communicator& ranks = request.Ranks ? *request.Ranks : GetAlone();
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(CheckIsWritable(request)));
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto searched, MakeCommonQuery(ranks, file, samples, request, progress));
  ContourBlocks blocks;
  const auto collect = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckIsOther(path, file.GetPath()));
    ISOSURFACE_RETURN_IF_ERROR(
      CollectVolumeBlocks(searched.Volume, searched.Query, samples.Level, blocks));
    blocks.Request = request;
    blocks.ArrayName = file.GetArrays()[samples.Array].Name;
    blocks.Volume = searched.Volume;
    blocks.Arrays = FindArrays(file, request);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, file.GetPath(), collect));
  return WriteBlocks(ranks, blocks, coding, path, settings, progress).GetStatus();
}

Result<std::array<double, 2>> ReadRange(
  VolumeFile& file, const ContouredSamples& samples, const Progress& progress)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto searched, MakeQuery(file, samples, {}, progress));
  const BlockedVolume& volume = *searched.Volume;
  const SurfaceQuery& query = searched.Query;
  return volume.GetHeader().TimeSteps[query.TimeStep].Ranges[query.Variable].GetValues(
    volume.GetVariables()[query.Variable].Type);
}

Result<double> EstimateTriangles(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress)
{
  SurfaceRequest everywhere = request;
  everywhere.Where = {};
  ISOSURFACE_ASSIGN_OR_RETURN(const auto searched, MakeQuery(file, samples, everywhere, progress));
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
