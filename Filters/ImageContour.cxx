// SPDX-License-Identifier: BSD-3-Clause
#include "ImageContour.h"

#include "vtkDataArray.h"

#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/SampleCopy.h"
#include "Surface/Contour/GridBlockSource.h"
#include "Surface/Contour/SurfaceMerge.h"
#include "Surface/Pieces/PieceBlockSource.h"

#include <utility>

namespace isosurface
{

namespace
{

constexpr const char* NotContoured = "the images of the input cannot be contoured";

/// Cells along a side; small, so that ranks share a coarse level out evenly.
constexpr int JoinedBlockSize = 16;

// The first id of each grid, and the one behind the last.
std::vector<std::int64_t> FindFirstIds(const ImagePieces& pieces, const ContourRequest& request)
{
  std::vector<std::int64_t> firstIds(1, 0);
  for (const GridGeometry& grid : pieces.Grids)
  {
    firstIds.push_back(firstIds.back() + CountGlobalIds(grid, request));
  }
  return firstIds;
}

SurfaceBlocks DescribeBlocks(const ImagePieces& pieces, const ContourRequest& request)
{
  return pieces.BlockNames.size() > 1
    ? SurfaceBlocks{ FindFirstIds(pieces, request), pieces.Blocks, pieces.BlockNames }
    : SurfaceBlocks();
}

// The surfaces of all grids, on all ranks, have points of one type, at all levels.
PointPrecision ChoosePrecision(const ImagePieces& pieces, PointPrecision wanted)
{
  for (std::size_t grid = 0; grid < pieces.Grids.size(); ++grid)
  {
    const auto& lines = pieces.Lines[grid];
    if (wanted == PointPrecision::Default &&
      NeedsDoublePoints(pieces.Grids[grid], lines ? &*lines : nullptr))
    {
      return PointPrecision::Double;
    }
  }
  return wanted == PointPrecision::Default ? PointPrecision::Single : wanted;
}

// Those of all pieces of this rank, which may have none.
Surface JoinSurfaces(const ImageContour::Query& query, std::vector<Surface>& surfaces)
{
  Surface joined = surfaces.size() == 1 ? std::move(surfaces.front()) : MergeSurfaces(surfaces);
  joined.HasDoublePoints = query.Request.Precision == PointPrecision::Double;
  return joined;
}

} // namespace

Result<ImageContour::Entry> ImageContour::TakeEntry(
  const ImagePiece& piece, int component, int threads)
{
  const ImageSamples& samples = piece.Samples;
  for (Entry& kept : this->Entries)
  {
    if (kept.Array == samples.Array && kept.Time == piece.GetTime() &&
      kept.Scalars.GetComponent() == component && kept.Box == samples.Components.front().Box)
    {
      return std::exchange(kept, Entry());
    }
  }
  Entry entry;
  entry.Array = samples.Array;
  entry.Time = piece.GetTime();
  entry.Box = samples.Components.front().Box;
  entry.Scalars = ChosenScalars(samples, component, threads);
  ISOSURFACE_ASSIGN_OR_RETURN(
    entry.Ranges, BlockRanges::Compute(entry.Scalars.GetView(samples), threads));
  return entry;
}

Result<ImageContour::Query> ImageContour::Query::Make(
  Communicator& ranks, ImagePieces pieces, const Settings& settings, const ContourRequest& request)
{
  Query query{ std::move(pieces), {}, {}, request, settings };
  const auto find = [&]() -> Status
  {
    for (const ImagePiece& piece : query.Pieces.Pieces)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(auto attributes,
        FindAttributes(piece, settings.Arrays, *settings.Averages, settings.Threads));
      if (query.Attributes.empty())
      {
        query.Arrays = attributes.Arrays;
      }
      else if (attributes.Arrays != query.Arrays)
      {
        return Status(StatusCode::InvalidArgument,
          "the arrays to interpolate are not of the same types in all images of the input");
      }
      query.Attributes.push_back(std::move(attributes));
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotContoured, find));
  query.Request.Precision = ChoosePrecision(query.Pieces, request.Precision);
  query.Request.Attributes.clear();
  for (const InterpolatedArray& array : query.Arrays)
  {
    query.Request.Attributes.push_back(array.Layout);
  }
  return query;
}

ImageContour::Query ImageContour::Query::Coarsen(int level, bool joins) const
{
  Query coarse = *this;
  coarse.Joins = joins;
  for (std::size_t grid = 0; grid < coarse.Pieces.Grids.size(); ++grid)
  {
    coarse.Pieces.Grids[grid] = this->Pieces.Grids[grid].Coarsen(level);
    if (auto& lines = coarse.Pieces.Lines[grid])
    {
      lines = lines->Coarsen(level);
    }
  }
  coarse.Pieces.Pieces.clear();
  coarse.Attributes.clear();
  for (std::size_t number = 0; number < this->Pieces.Pieces.size(); ++number)
  {
    ImagePiece piece = this->Pieces.Pieces[number];
    PieceAttributes attributes = this->Attributes[number];
    for (SampleView& view : piece.Samples.Components)
    {
      view = isosurface::Coarsen(view, level);
    }
    for (AttributeView& attribute : attributes.Views)
    {
      for (SampleView& view : attribute.Components)
      {
        view = isosurface::Coarsen(view, level);
      }
    }
    if (!piece.Samples.Components.front().Box.IsEmpty())
    {
      coarse.Pieces.Pieces.push_back(std::move(piece));
      coarse.Attributes.push_back(std::move(attributes));
    }
  }
  return coarse;
}

IslandGrids ImageContour::Query::MakeIslandGrids(const Communicator& ranks) const
{
  IslandGrids islands;
  const std::vector<std::int64_t> firstIds = FindFirstIds(this->Pieces, this->Request);
  for (std::size_t grid = 0; grid < this->Pieces.Grids.size(); ++grid)
  {
    const auto& lines = this->Pieces.Lines[grid];
    islands.Bounds.Extend(TriangleBounds::Of(this->Pieces.Grids[grid], lines ? &*lines : nullptr));
    islands.Shared.emplace_back(this->Pieces.Grids[grid], this->Request, firstIds[grid]);
    if (this->Joins)
    {
      islands.Shared.back().AddFacesOfBlocks(JoinedBlockSize);
    }
  }
  const bool areAlone = ranks.GetSize() == 1 && this->Pieces.Pieces.size() == 1;
  for (const ImagePiece& piece : this->Pieces.Pieces)
  {
    const VertexBox& box = piece.Samples.Components.front().Box;
    const bool hasFaces = !areAlone && box.GetNumberOfVertices() > 0;
    for (std::size_t axis = 0; axis < 3 && hasFaces; ++axis)
    {
      islands.Shared[piece.Grid].Add(axis, box.Low[axis]);
      islands.Shared[piece.Grid].Add(axis, box.High[axis] - 1);
    }
  }
  return islands;
}

Result<Surface> ImageContour::ExtractPiece(
  const Query& query, std::size_t number, const Prepared& prepared, const Progress& progress)
{
  const LayeredPiece& piece = prepared.Pieces[number];
  const GridGeometry& grid = query.Pieces.Grids[piece.Grid];
  const std::optional<GridLines>& lines = query.Pieces.Lines[piece.Grid];
  ContourRequest request = query.Request;
  request.KnownSamples = piece.Scalars.Available;
  request.Lines = lines ? &*lines : nullptr;
  GridBlockSource source(piece.Scalars, prepared.Entries[number].Ranges, request.Isovalues,
    { request.ClosedSides, query.Choice.Region, request.Lines }, grid);
  source.SetAttributes(query.Attributes[number].Views);
  source.SetBlanking(piece.Hidden);
  const std::vector<PieceLayers::Part>& layer = prepared.Layers.GetParts(number);
  if (layer.empty())
  {
    return ExtractSurface(grid, source, request, query.Choice.Threads, progress);
  }
  LayeredBlockSource layered(source, piece, layer);
  request.KnownSamples = layered.GetKnownSamples();
  return ExtractSurface(grid, layered, request, query.Choice.Threads, progress);
}

Status ImageContour::Prepare(const Query& query, Prepared& prepared)
{
  for (const ImagePiece& piece : query.Pieces.Pieces)
  {
    const int component = *FindChosenComponent(
      static_cast<int>(piece.Samples.Components.size()), query.Choice.Component);
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto entry, this->TakeEntry(piece, component, query.Choice.Threads));
    prepared.Entries.push_back(std::move(entry));
    prepared.Pieces.push_back({ piece.Grid, query.Pieces.Grids[piece.Grid].GetDimensions(),
      prepared.Entries.back().Scalars.GetView(piece.Samples), piece.Samples.Hidden });
  }
  prepared.Layers.Resize(prepared.Pieces.size());
  return Status::Ok();
}

Status ImageContour::Extract(
  Communicator& ranks, const Query& query, const Progress& progress, ContourOutcome& outcome)
{
  if (query.Joins)
  {
    const Status status = ExtractJoined(ranks, query, progress, outcome);
    // One rank alone may know that its pieces are of different types.
    const bool cannotJoin = ranks.Any(status.GetCode() == StatusCode::InvalidArgument);
    if (!cannotJoin)
    {
      return status;
    }
  }
  return this->ExtractPieces(ranks, query, progress, outcome);
}

Status ImageContour::ExtractJoined(
  Communicator& ranks, const Query& query, const Progress& progress, ContourOutcome& outcome)
{
  const std::vector<ImagePiece>& pieces = query.Pieces.Pieces;
  std::vector<ChosenScalars> scalars;
  std::vector<std::vector<GridPiece>> ofGrids;
  std::vector<Surface> surfaces;
  const auto choose = [&]
  {
    ofGrids.resize(query.Pieces.Grids.size());
    surfaces.reserve(ofGrids.size());
    scalars.reserve(pieces.size());
    for (std::size_t number = 0; number < pieces.size(); ++number)
    {
      const ImageSamples& samples = pieces[number].Samples;
      const auto components = static_cast<int>(samples.Components.size());
      scalars.emplace_back(
        samples, *FindChosenComponent(components, query.Choice.Component), query.Choice.Threads);
      ofGrids[pieces[number].Grid].push_back(
        { scalars.back().GetView(samples), query.Attributes[number].Views });
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotContoured, choose));
  const std::vector<std::int64_t> firstIds = FindFirstIds(query.Pieces, query.Request);
  std::size_t blocks = 0;
  for (std::size_t grid = 0; grid < query.Pieces.Grids.size(); ++grid)
  {
    const std::optional<GridLines>& lines = query.Pieces.Lines[grid];
    const PieceBlockSelection selection = { query.Request.Isovalues, query.Choice.Region,
      query.Request.ClosedSides, lines ? &*lines : nullptr, JoinedBlockSize,
      query.Request.Normals };
    ISOSURFACE_ASSIGN_OR_RETURN(const auto source,
      PieceBlockSource::Make(ranks, query.Pieces.Grids[grid], std::move(ofGrids[grid]), selection,
        query.Choice.Threads));
    ContourRequest request = query.Request;
    request.Lines = selection.Lines;
    auto extracted =
      ExtractSurface(query.Pieces.Grids[grid], *source, request, query.Choice.Threads, progress);
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(extracted.GetStatus()));
    blocks += extracted->NumberOfBlocks;
    ShiftGlobalIds(firstIds[grid], *extracted);
    surfaces.push_back(std::move(*extracted));
  }
  const auto merge = [&]
  {
    outcome.Arrays = query.Arrays;
    outcome.Blocks = DescribeBlocks(query.Pieces, query.Request);
    outcome.Cost.Reading.ActiveBlocks += blocks;
    outcome.Extracted = JoinSurfaces(query, surfaces);
    return Status::Ok();
  };
  return Attempt(NotContoured, merge);
}

Status ImageContour::ExtractPieces(
  Communicator& ranks, const Query& query, const Progress& progress, ContourOutcome& outcome)
{
  Prepared prepared;
  const auto prepare = [&] { return this->Prepare(query, prepared); };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotContoured, prepare));
  if (query.Request.Normals)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(prepared.Layers, PieceLayers::Collect(ranks, prepared.Pieces));
  }
  return Attempt(
    NotContoured, [&] { return this->ExtractPrepared(query, prepared, progress, outcome); });
}

Status ImageContour::ExtractPrepared(
  const Query& query, Prepared& prepared, const Progress& progress, ContourOutcome& outcome)
{
  const std::vector<ImagePiece>& pieces = query.Pieces.Pieces;
  outcome.Arrays = query.Arrays;
  outcome.Blocks = DescribeBlocks(query.Pieces, query.Request);
  const std::vector<std::int64_t> firstIds = FindFirstIds(query.Pieces, query.Request);
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
  outcome.Extracted = JoinSurfaces(query, surfaces);
  return Status::Ok();
}

} // namespace isosurface
