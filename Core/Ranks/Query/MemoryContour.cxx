// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/MemoryContour.h"

#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/SampleCopy.h"
#include "Surface/Contour/GridBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Contour/SurfaceMerge.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

constexpr const char* NotContoured = "the images of the input cannot be contoured";

/// Cells along a side; small, so that ranks share a coarse level out evenly.
constexpr int JoinedBlockSize = 16;

/// Those of all pieces of this rank, which may have none.
Surface JoinPieces(const MemoryQuery& query, std::vector<Surface>& surfaces)
{
  Surface joined = surfaces.size() == 1 ? std::move(surfaces.front()) : MergeSurfaces(surfaces);
  joined.HasDoublePoints = query.Request.Precision == PointPrecision::Double;
  return joined;
}

} // namespace

MemoryQuery MemoryQuery::Coarsen(int level, bool joins) const
{
  MemoryQuery coarse = *this;
  coarse.Joins = joins;
  for (std::size_t grid = 0; grid < coarse.Samples.Grids.size(); ++grid)
  {
    coarse.Samples.Grids[grid] = this->Samples.Grids[grid].Coarsen(level);
    if (auto& lines = coarse.Samples.Lines[grid])
    {
      lines = lines->Coarsen(level);
    }
  }
  coarse.Samples.Pieces.clear();
  for (MemoryPiece piece : this->Samples.Pieces)
  {
    for (SampleView& view : piece.Components)
    {
      view = isosurface::Coarsen(view, level);
    }
    for (AttributeView& attribute : piece.Attributes)
    {
      for (SampleView& view : attribute.Components)
      {
        view = isosurface::Coarsen(view, level);
      }
    }
    if (!piece.Components.front().Box.IsEmpty())
    {
      coarse.Samples.Pieces.push_back(std::move(piece));
    }
  }
  return coarse;
}

std::vector<std::int64_t> MemoryQuery::FindFirstIds() const
{
  std::vector<std::int64_t> firstIds(1, 0);
  for (const GridGeometry& grid : this->Samples.Grids)
  {
    firstIds.push_back(firstIds.back() + CountGlobalIds(grid, this->Request));
  }
  return firstIds;
}

std::vector<std::int32_t> MemoryQuery::FindBlocks(
  const Surface& surface, const std::vector<std::size_t>& blocks) const
{
  const std::vector<std::int64_t> firstIds = this->FindFirstIds();
  std::vector<std::int32_t> found;
  found.reserve(surface.NumberOfPoints);
  for (const std::int64_t id : surface.GlobalIds)
  {
    const auto next = std::upper_bound(firstIds.begin(), firstIds.end(), id);
    const auto grid = static_cast<std::size_t>(next - firstIds.begin() - 1);
    found.push_back(static_cast<std::int32_t>(blocks[grid]));
  }
  return found;
}

IslandGrids MemoryQuery::MakeIslandGrids(const Communicator& ranks) const
{
  IslandGrids islands;
  const MemoryGrids& samples = this->Samples;
  const std::vector<std::int64_t> firstIds = this->FindFirstIds();
  for (std::size_t grid = 0; grid < samples.Grids.size(); ++grid)
  {
    const auto& lines = samples.Lines[grid];
    islands.Bounds.Extend(TriangleBounds::Of(samples.Grids[grid], lines ? &*lines : nullptr));
    islands.Shared.emplace_back(samples.Grids[grid], this->Request, firstIds[grid]);
    if (this->Joins)
    {
      islands.Shared.back().AddFacesOfBlocks(JoinedBlockSize);
    }
  }
  const bool areAlone = ranks.GetSize() == 1 && samples.Pieces.size() == 1;
  for (const MemoryPiece& piece : samples.Pieces)
  {
    const VertexBox& box = piece.Components.front().Box;
    const bool hasFaces = !areAlone && box.GetNumberOfVertices() > 0;
    for (std::size_t axis = 0; axis < 3 && hasFaces; ++axis)
    {
      islands.Shared[piece.Grid].Add(axis, box.Low[axis]);
      islands.Shared[piece.Grid].Add(axis, box.High[axis] - 1);
    }
  }
  return islands;
}

Result<MemoryContour::Entry> MemoryContour::TakeEntry(
  const MemoryPiece& piece, int choice, int threads)
{
  const VertexBox& box = piece.Components.front().Box;
  const int component = *FindChosenComponent(static_cast<int>(piece.Components.size()), choice);
  for (Entry& kept : this->Entries)
  {
    if (kept.Identity == piece.Identity && kept.Scalars.GetComponent() == component &&
      kept.Box == box)
    {
      return std::exchange(kept, Entry());
    }
  }
  Entry entry;
  entry.Identity = piece.Identity;
  entry.Box = box;
  entry.Scalars = ChosenScalars(piece.Components, choice, threads);
  ISOSURFACE_ASSIGN_OR_RETURN(
    entry.Ranges, BlockRanges::Compute(entry.Scalars.GetView(piece.Components), threads));
  return entry;
}

Result<Surface> MemoryContour::ExtractPiece(
  const MemoryQuery& query, std::size_t number, const Prepared& prepared, const Progress& progress)
{
  const LayeredPiece& piece = prepared.Pieces[number];
  const GridGeometry& grid = query.Samples.Grids[piece.Grid];
  const std::optional<GridLines>& lines = query.Samples.Lines[piece.Grid];
  ContourRequest request = query.Request;
  request.KnownSamples = piece.Scalars.Available;
  request.Lines = lines ? &*lines : nullptr;
  GridBlockSource source(piece.Scalars, prepared.Entries[number].Ranges, request.Isovalues,
    { request.ClosedSides, query.Region, request.Lines }, grid);
  source.SetAttributes(query.Samples.Pieces[number].Attributes);
  source.SetBlanking(piece.Hidden);
  const std::vector<PieceLayers::LayerBox>& layer = prepared.Layers.GetLayer(number);
  if (layer.empty())
  {
    return ExtractSurface(grid, source, request, query.Threads, progress);
  }
  LayeredBlockSource layered(source, piece, layer);
  request.KnownSamples = layered.GetKnownSamples();
  return ExtractSurface(grid, layered, request, query.Threads, progress);
}

Status MemoryContour::Prepare(const MemoryQuery& query, Prepared& prepared)
{
  for (const MemoryPiece& piece : query.Samples.Pieces)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto entry, this->TakeEntry(piece, query.Component, query.Threads));
    prepared.Entries.push_back(std::move(entry));
    prepared.Pieces.push_back({ piece.Grid, query.Samples.Grids[piece.Grid].GetDimensions(),
      prepared.Entries.back().Scalars.GetView(piece.Components), piece.Hidden });
  }
  prepared.Layers.Resize(prepared.Pieces.size());
  return Status::Ok();
}

Result<std::vector<JoinedGrids>> JoinedGrids::Make(
  Communicator& ranks, const Status& prepared, std::vector<MemoryQuery> queries)
{
  std::vector<JoinedGrids> joined;
  std::vector<PieceBlockInput> inputs;
  int threads = 1;
  const auto prepare = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(prepared);
    for (MemoryQuery& query : queries)
    {
      threads = query.Threads;
      const std::size_t first = inputs.size();
      joined.emplace_back();
      joined.back().Query = std::move(query);
      JoinedGrids& grids = joined.back();
      for (std::size_t grid = 0; grid < grids.Query.Samples.Grids.size(); ++grid)
      {
        const ContourRequest& request = grids.Query.Request;
        const std::optional<GridLines>& lines = grids.Query.Samples.Lines[grid];
        inputs.push_back({ grids.Query.Samples.Grids[grid], {},
          { request.Isovalues, grids.Query.Region, request.ClosedSides, lines ? &*lines : nullptr,
            JoinedBlockSize, request.Normals } });
      }
      grids.Scalars.reserve(grids.Query.Samples.Pieces.size());
      for (const MemoryPiece& piece : grids.Query.Samples.Pieces)
      {
        grids.Scalars.emplace_back(piece.Components, grids.Query.Component, threads);
        inputs[first + piece.Grid].Pieces.push_back(
          { grids.Scalars.back().GetView(piece.Components), piece.Attributes });
      }
    }
    return Status::Ok();
  };
  const Status status = Attempt(NotContoured, prepare);
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto sources, PieceBlockSource::MakeAll(ranks, status, std::move(inputs), threads));
  auto next = sources.begin();
  for (JoinedGrids& grids : joined)
  {
    const auto end = next + static_cast<std::ptrdiff_t>(grids.Query.Samples.Grids.size());
    grids.Sources.assign(std::move_iterator(next), std::move_iterator(end));
    next = end;
  }
  return joined;
}

Status JoinedGrids::FindFault() const
{
  Status fault;
  for (const auto& source : this->Sources)
  {
    if (fault.IsOk() || source->GetStatus().GetCode() == StatusCode::InvalidArgument)
    {
      fault = source->GetStatus();
    }
  }
  return fault;
}

Status MemoryContour::Extract(Communicator& ranks, const Status& prepared, const MemoryQuery& query,
  const Progress& progress, ExtractionOutcome& outcome)
{
  if (!query.Joins)
  {
    return this->ExtractPieces(ranks, prepared, query, progress, outcome);
  }
  std::vector<MemoryQuery> queries;
  const auto add = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(prepared);
    queries.push_back(query);
    return Status::Ok();
  };
  const Status added = Attempt(NotContoured, add);
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto joined, JoinedGrids::Make(ranks, added, std::move(queries)));
  return this->Extract(ranks, joined.front(), progress, outcome);
}

Status MemoryContour::Extract(Communicator& ranks, const JoinedGrids& joined,
  const Progress& progress, ExtractionOutcome& outcome)
{
  const Status fault = joined.FindFault();
  if (fault.GetCode() == StatusCode::InvalidArgument)
  {
    return this->ExtractPieces(ranks, Status::Ok(), joined.Query, progress, outcome);
  }
  ISOSURFACE_RETURN_IF_ERROR(fault);
  return Attempt(NotContoured, [&] { return ExtractJoined(joined, progress, outcome); });
}

Status MemoryContour::ExtractJoined(
  const JoinedGrids& joined, const Progress& progress, ExtractionOutcome& outcome)
{
  const MemoryQuery& query = joined.Query;
  const std::vector<std::int64_t> firstIds = query.FindFirstIds();
  std::vector<Surface> surfaces;
  for (std::size_t grid = 0; grid < joined.Sources.size(); ++grid)
  {
    const std::optional<GridLines>& lines = query.Samples.Lines[grid];
    ContourRequest request = query.Request;
    request.Lines = lines ? &*lines : nullptr;
    ISOSURFACE_ASSIGN_OR_RETURN(auto extracted,
      ExtractSurface(
        query.Samples.Grids[grid], *joined.Sources[grid], request, query.Threads, progress));
    outcome.Cost.Reading.ActiveBlocks += extracted.NumberOfBlocks;
    ShiftGlobalIds(firstIds[grid], extracted);
    surfaces.push_back(std::move(extracted));
  }
  outcome.Extracted = JoinPieces(query, surfaces);
  return Status::Ok();
}

Status MemoryContour::ExtractPieces(Communicator& ranks, const Status& given,
  const MemoryQuery& query, const Progress& progress, ExtractionOutcome& outcome)
{
  Prepared prepared;
  const Status status =
    given.IsOk() ? Attempt(NotContoured, [&] { return this->Prepare(query, prepared); }) : given;
  if (query.Request.Normals)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      prepared.Layers, PieceLayers::Collect(ranks, status, prepared.Pieces));
  }
  ISOSURFACE_RETURN_IF_ERROR(status);
  return Attempt(
    NotContoured, [&] { return this->ExtractPrepared(query, prepared, progress, outcome); });
}

Status MemoryContour::ExtractPrepared(const MemoryQuery& query, Prepared& prepared,
  const Progress& progress, ExtractionOutcome& outcome)
{
  const std::vector<MemoryPiece>& pieces = query.Samples.Pieces;
  const std::vector<std::int64_t> firstIds = query.FindFirstIds();
  std::vector<Surface> surfaces;
  for (std::size_t number = 0; number < pieces.size(); ++number)
  {
    const auto advance = [&](double share)
    {
      return !progress ||
        progress((static_cast<double>(number) + share) / static_cast<double>(pieces.size()));
    };
    ISOSURFACE_ASSIGN_OR_RETURN(auto extracted, ExtractPiece(query, number, prepared, advance));
    outcome.Cost.Reading.ActiveBlocks += extracted.NumberOfBlocks;
    ShiftGlobalIds(firstIds[pieces[number].Grid], extracted);
    surfaces.push_back(std::move(extracted));
  }
  this->Entries = std::move(prepared.Entries);
  outcome.Extracted = JoinPieces(query, surfaces);
  return Status::Ok();
}

} // namespace isosurface
