// SPDX-License-Identifier: BSD-3-Clause
#include "ImageContour.h"

#include "vtkDataArray.h"

#include "Contour/GridBlockSource.h"
#include "Contour/SurfaceMerge.h"
#include "Volume/ArrayVariables.h"

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

Result<Surface> ImageContour::ExtractPiece(const ImagePieces& pieces, const ImagePiece& piece,
  const PieceAttributes& attributes, const Entry& entry, const Settings& settings,
  ContourRequest request, const Progress& progress)
{
  const SampleView samples = entry.Scalars.GetView(piece.Samples);
  const GridGeometry& grid = pieces.Grids[piece.Grid];
  const std::optional<GridLines>& lines = pieces.Lines[piece.Grid];
  request.KnownSamples = samples.Available;
  request.Lines = lines ? &*lines : nullptr;
  GridBlockSource source(samples, entry.Ranges, request.Isovalues,
    { request.ClosedSides, settings.Region, request.Lines }, grid);
  source.SetAttributes(attributes.Views);
  source.SetBlanking(piece.Samples.Hidden);
  return ExtractSurface(grid, source, request, settings.Threads, progress);
}

Result<ImageContour::Outcome> ImageContour::Extract(const ImagePieces& pieces,
  const Settings& settings, ContourRequest& request, const Progress& progress)
{
  const std::vector<std::int64_t> firstIds = FindFirstIds(pieces, request);
  Outcome outcome;
  std::vector<Surface> surfaces;
  std::vector<Entry> used;
  request.Attributes.clear();
  for (std::size_t number = 0; number < pieces.Pieces.size(); ++number)
  {
    const ImagePiece& piece = pieces.Pieces[number];
    const auto attributes =
      FindAttributes(piece, settings.Arrays, *settings.Averages, settings.Threads);
    ISOSURFACE_RETURN_IF_ERROR(attributes.GetStatus());
    if (number == 0)
    {
      outcome.Arrays = attributes->Arrays;
      for (const InterpolatedArray& array : outcome.Arrays)
      {
        request.Attributes.push_back(array.Layout);
      }
    }
    else if (attributes->Arrays != outcome.Arrays)
    {
      return Status(StatusCode::InvalidArgument,
        "the arrays to interpolate are not of the same types in all images of the input");
    }
    const int component =
      *FindChosenComponent(static_cast<int>(piece.Samples.Components.size()), settings.Component);
    auto entry = this->TakeEntry(piece.Samples, component, settings.Threads);
    ISOSURFACE_RETURN_IF_ERROR(entry.GetStatus());
    used.push_back(std::move(*entry));
    const auto advance = [&](double share)
    {
      return !progress ||
        progress((static_cast<double>(number) + share) / static_cast<double>(pieces.Pieces.size()));
    };
    auto extracted =
      ExtractPiece(pieces, piece, *attributes, used.back(), settings, request, advance);
    ISOSURFACE_RETURN_IF_ERROR(extracted.GetStatus());
    outcome.ActiveBlocks += extracted->NumberOfBlocks;
    ShiftGlobalIds(firstIds[piece.Grid], *extracted);
    surfaces.push_back(std::move(*extracted));
  }
  this->Entries = std::move(used);
  outcome.Extracted = surfaces.size() == 1 ? std::move(surfaces.front()) : MergeSurfaces(surfaces);
  return outcome;
}

} // namespace isosurface
