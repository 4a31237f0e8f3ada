// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/MemoryContour.h"

#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/SampleCopy.h"
#include "Surface/Contour/GridBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Contour/SurfaceMerge.h"
#include "Surface/Pieces/PieceBlockSource.h"

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

Status MemoryContour::Extract(Communicator& ranks, const MemoryQuery& query,
  const Progress& progress, ExtractionOutcome& outcome)
{
  if (query.Joins)
  {
    const Status status = ExtractJoined(ranks, query, progress, outcome);
    // One rank alone may know that its pieces are of different types.
    if (!ranks.Any(status.GetCode() == StatusCode::InvalidArgument))
    {
      return status;
    }
  }
  return this->ExtractPieces(ranks, query, progress, outcome);
}

Status MemoryContour::ExtractJoined(Communicator& ranks, const MemoryQuery& query,
  const Progress& progress, ExtractionOutcome& outcome)
{
  const std::vector<MemoryPiece>& pieces = query.Samples.Pieces;
  const std::vector<GridGeometry>& grids = query.Samples.Grids;
  std::vector<ChosenScalars> scalars;
  std::vector<std::vector<GridPiece>> ofGrids;
  std::vector<Surface> surfaces;
  const auto choose = [&]
  {
    ofGrids.resize(grids.size());
    surfaces.reserve(ofGrids.size());
    scalars.reserve(pieces.size());
    for (const MemoryPiece& piece : pieces)
    {
      scalars.emplace_back(piece.Components, query.Component, query.Threads);
      ofGrids[piece.Grid].push_back({ scalars.back().GetView(piece.Components), piece.Attributes });
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotContoured, choose));
  const std::vector<std::int64_t> firstIds = query.FindFirstIds();
  std::size_t blocks = 0;
  for (std::size_t grid = 0; grid < grids.size(); ++grid)
  {
    const std::optional<GridLines>& lines = query.Samples.Lines[grid];
    const PieceBlockSelection selection = { query.Request.Isovalues, query.Region,
      query.Request.ClosedSides, lines ? &*lines : nullptr, JoinedBlockSize,
      query.Request.Normals };
    ISOSURFACE_ASSIGN_OR_RETURN(const auto source,
      PieceBlockSource::Make(
        ranks, grids[grid], std::move(ofGrids[grid]), selection, query.Threads));
    ContourRequest request = query.Request;
    request.Lines = selection.Lines;
    auto extracted = ExtractSurface(grids[grid], *source, request, query.Threads, progress);
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(extracted.GetStatus()));
    blocks += extracted->NumberOfBlocks;
    ShiftGlobalIds(firstIds[grid], *extracted);
    surfaces.push_back(std::move(*extracted));
  }
  const auto merge = [&]
  {
    outcome.Cost.Reading.ActiveBlocks += blocks;
    outcome.Extracted = JoinPieces(query, surfaces);
    return Status::Ok();
  };
  return Attempt(NotContoured, merge);
}

Status MemoryContour::ExtractPieces(Communicator& ranks, const MemoryQuery& query,
  const Progress& progress, ExtractionOutcome& outcome)
{
  Prepared prepared;
  const Status status = Attempt(NotContoured, [&] { return this->Prepare(query, prepared); });
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
