// SPDX-License-Identifier: BSD-3-Clause
#include "ImageSpectrum.h"

#include "ChosenScalars.h"
#include "ErrorReport.h"
#include "Ground/Base/Fingerprint.h"
#include "Surface/Spectrum/GridSpectrum.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

constexpr const char* NotCounted = "the spectrum cannot be made";

/// The type of the scalars of all ranks; nothing if there are none, an error if there are several.
Result<std::optional<ValueType>> FindType(
  Communicator& ranks, const std::vector<SampleView>& scalars)
{
  constexpr std::uint64_t none = 1000;
  std::vector<std::uint64_t> minimum = { none };
  std::vector<std::uint64_t> maximum = { 0 };
  for (const SampleView& view : scalars)
  {
    const auto type = static_cast<std::uint64_t>(view.Type);
    minimum[0] = std::min(minimum[0], type);
    maximum[0] = std::max(maximum[0], type);
  }
  ranks.ReduceMinimum(minimum);
  ranks.ReduceMaximum(maximum);
  if (minimum[0] == none)
  {
    return std::optional<ValueType>();
  }
  if (minimum[0] != maximum[0])
  {
    return Status(StatusCode::InvalidArgument,
      "the input's images have arrays of several types; their values cannot share bins");
  }
  return std::optional<ValueType>(static_cast<ValueType>(minimum[0]));
}

/// scalars: those of each piece.
std::vector<GridSpectrum> MakeGridSpectra(
  const ImagePieces& pieces, const std::vector<SampleView>& scalars, ValueType type, int threads)
{
  std::vector<GridSpectrum> spectra;
  for (std::size_t grid = 0; grid < pieces.Grids.size(); ++grid)
  {
    std::vector<SampleView> views;
    for (std::size_t piece = 0; piece < pieces.Pieces.size(); ++piece)
    {
      if (pieces.Pieces[piece].Grid == grid)
      {
        views.push_back(scalars[piece]);
      }
    }
    MeasuredGrid measured{ pieces.Grids[grid] };
    if (const auto& lines = pieces.Lines[grid])
    {
      measured.Lines = &*lines;
      measured.Geometry =
        lines->MakeFrame(measured.Geometry, { { 0, 0, 0 }, measured.Geometry.GetDimensions() });
    }
    spectra.emplace_back(measured, type, std::move(views), threads);
  }
  return spectra;
}

/// The spectra of the grids, in equal bins.
Result<std::vector<WorkloadSpectrum>> CountGrids(
  Communicator& ranks, ValueType type, std::vector<GridSpectrum> grids, const Progress& progress)
{
  // Ranges, then counts, of each grid.
  double begin = 0;
  const double part = 0.5 / static_cast<double>(grids.size());
  const auto makeProgress = [&]() -> Progress
  {
    begin += part;
    return [&progress, from = begin - part, part](double share)
    { return !progress || progress(from + part * share); };
  };
  KeyRange finite;
  for (GridSpectrum& grid : grids)
  {
    ISOSURFACE_RETURN_IF_ERROR(grid.FindRanges(ranks, makeProgress()));
    finite.Add(grid.GetFiniteRange());
  }
  const auto bins = SpectrumBins::Choose(type, finite);
  std::vector<WorkloadSpectrum> spectra;
  for (const GridSpectrum& grid : grids)
  {
    auto spectrum = grid.Count(ranks, bins, makeProgress());
    ISOSURFACE_RETURN_IF_ERROR(spectrum.GetStatus());
    spectra.push_back(std::move(*spectrum));
  }
  return spectra;
}

} // namespace

Status ImageSpectrum::Collect(Communicator& ranks, vtkInformation* input,
  const ArrayChooser& choose, const std::string& name, int component, int threads)
{
  auto pieces =
    CollectContouredPieces(ranks, input, choose, name, component, this->Averages, threads);
  ISOSURFACE_RETURN_IF_ERROR(pieces.GetStatus());
  this->Pieces = std::move(*pieces);
  this->Component = component;
  this->Threads = threads;
  return Status::Ok();
}

std::uint64_t ImageSpectrum::ComputeFingerprint() const
{
  Fingerprint fingerprint;
  fingerprint.AddNumber(static_cast<std::uint64_t>(this->Component));
  for (const ImagePiece& piece : this->Pieces.Pieces)
  {
    fingerprint.AddNumber(reinterpret_cast<std::uintptr_t>(piece.Samples.Array.Get()));
    fingerprint.AddNumber(piece.GetTime());
  }
  return fingerprint.Get();
}

std::uint64_t ImageSpectrum::CountSamples() const
{
  std::uint64_t samples = 0;
  for (const ImagePiece& piece : this->Pieces.Pieces)
  {
    samples +=
      static_cast<std::uint64_t>(piece.Samples.Components.front().Box.GetNumberOfVertices());
  }
  return samples;
}

Status ImageSpectrum::Count(Communicator& ranks, const Progress& progress)
{
  std::vector<ChosenScalars> chosen;
  std::vector<SampleView> scalars;
  const auto choose = [&]
  {
    for (const ImagePiece& piece : this->Pieces.Pieces)
    {
      const int component =
        *FindChosenComponent(static_cast<int>(piece.Samples.Components.size()), this->Component);
      chosen.emplace_back(piece.Samples, component, this->Threads);
      scalars.push_back(chosen.back().GetView(piece.Samples));
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotCounted, choose));
  const auto type = FindType(ranks, scalars);
  if (!type.IsOk() || !*type)
  {
    return type.GetStatus();
  }
  std::vector<GridSpectrum> grids;
  const auto make = [&]
  {
    grids = MakeGridSpectra(this->Pieces, scalars, **type, this->Threads);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotCounted, make));
  auto spectra = CountGrids(ranks, **type, std::move(grids), progress);
  ISOSURFACE_RETURN_IF_ERROR(spectra.GetStatus());
  this->Spectra = std::move(*spectra);
  return Status::Ok();
}

} // namespace isosurface
