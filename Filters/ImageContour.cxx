// SPDX-License-Identifier: BSD-3-Clause
#include "ImageContour.h"

#include "vtkDataArray.h"

#include "Ground/Volume/ArrayVariables.h"
#include "Surface/Contour/GridBlockSource.h"
#include "Surface/Contour/SurfaceMerge.h"

#include <utility>

namespace isosurface
{

namespace
{

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

} // namespace

Result<ImageContour::Entry> ImageContour::TakeEntry(
  const ImageSamples& samples, int component, int threads)
{
  for (Entry& kept : this->Entries)
  {
    if (kept.Array == samples.Array && kept.Time == samples.Time &&
      kept.Scalars.GetComponent() == component && kept.Box == samples.Components.front().Box)
    {
      return std::exchange(kept, Entry());
    }
  }
  Entry entry;
  entry.Array = samples.Array;
  entry.Time = samples.Time;
  entry.Box = samples.Components.front().Box;
  entry.Scalars = ChosenScalars(samples, component, threads);
  auto ranges = BlockRanges::Compute(entry.Scalars.GetView(samples), threads);
  ISOSURFACE_RETURN_IF_ERROR(ranges.GetStatus());
  entry.Ranges = std::move(*ranges);
  return entry;
}

Result<Surface> ImageContour::ExtractPiece(const ImagePieces& pieces, std::size_t number,
  const Prepared& prepared, const Settings& settings, ContourRequest request,
  const Progress& progress)
{
  const LayeredPiece& piece = prepared.Pieces[number];
  const GridGeometry& grid = pieces.Grids[piece.Grid];
  const std::optional<GridLines>& lines = pieces.Lines[piece.Grid];
  request.KnownSamples = piece.Scalars.Available;
  request.Lines = lines ? &*lines : nullptr;
  GridBlockSource source(piece.Scalars, prepared.Entries[number].Ranges, request.Isovalues,
    { request.ClosedSides, settings.Region, request.Lines }, grid);
  source.SetAttributes(prepared.Attributes[number].Views);
  source.SetBlanking(piece.Hidden);
  const std::vector<PieceLayers::Part>& layer = prepared.Layers.GetParts(number);
  if (layer.empty())
  {
    return ExtractSurface(grid, source, request, settings.Threads, progress);
  }
  LayeredBlockSource layered(source, piece, layer);
  request.KnownSamples = layered.GetKnownSamples();
  return ExtractSurface(grid, layered, request, settings.Threads, progress);
}

Status ImageContour::Prepare(const ImagePieces& pieces, const Settings& settings,
  Prepared& prepared, std::vector<InterpolatedArray>& arrays)
{
  for (const ImagePiece& piece : pieces.Pieces)
  {
    auto attributes = FindAttributes(piece, settings.Arrays, *settings.Averages, settings.Threads);
    ISOSURFACE_RETURN_IF_ERROR(attributes.GetStatus());
    if (prepared.Pieces.empty())
    {
      arrays = attributes->Arrays;
    }
    else if (attributes->Arrays != arrays)
    {
      return Status(StatusCode::InvalidArgument,
        "the arrays to interpolate are not of the same types in all images of the input");
    }
    const int component =
      *FindChosenComponent(static_cast<int>(piece.Samples.Components.size()), settings.Component);
    auto entry = this->TakeEntry(piece.Samples, component, settings.Threads);
    ISOSURFACE_RETURN_IF_ERROR(entry.GetStatus());
    prepared.Entries.push_back(std::move(*entry));
    prepared.Attributes.push_back(std::move(*attributes));
    prepared.Pieces.push_back({ piece.Grid, pieces.Grids[piece.Grid].GetDimensions(),
      prepared.Entries.back().Scalars.GetView(piece.Samples), piece.Samples.Hidden });
  }
  return Status::Ok();
}

Status ImageContour::Extract(Communicator& ranks, const ImagePieces& pieces,
  const Settings& settings, ContourRequest& request, const Progress& progress,
  ContourOutcome& outcome)
{
  Prepared prepared;
  const auto prepare = [&] { return this->Prepare(pieces, settings, prepared, outcome.Arrays); };
  ISOSURFACE_RETURN_IF_ERROR(
    ranks.Agree(Attempt("the images of the input cannot be contoured", prepare)));
  prepared.Layers.Resize(pieces.Pieces.size());
  if (request.Normals)
  {
    auto layers = PieceLayers::Collect(ranks, prepared.Pieces);
    ISOSURFACE_RETURN_IF_ERROR(layers.GetStatus());
    prepared.Layers = std::move(*layers);
  }
  request.Attributes.clear();
  for (const InterpolatedArray& array : outcome.Arrays)
  {
    request.Attributes.push_back(array.Layout);
  }
  const std::vector<std::int64_t> firstIds = FindFirstIds(pieces, request);
  std::vector<Surface> surfaces;
  for (std::size_t number = 0; number < pieces.Pieces.size(); ++number)
  {
    const auto advance = [&](double share)
    {
      return !progress ||
        progress((static_cast<double>(number) + share) / static_cast<double>(pieces.Pieces.size()));
    };
    auto extracted = ExtractPiece(pieces, number, prepared, settings, request, advance);
    ISOSURFACE_RETURN_IF_ERROR(extracted.GetStatus());
    outcome.Cost.Reading.ActiveBlocks += extracted->NumberOfBlocks;
    ShiftGlobalIds(firstIds[pieces.Pieces[number].Grid], *extracted);
    surfaces.push_back(std::move(*extracted));
  }
  this->Entries = std::move(prepared.Entries);
  outcome.Extracted = surfaces.size() == 1 ? std::move(surfaces.front()) : MergeSurfaces(surfaces);
  return Status::Ok();
}

} // namespace isosurface
