// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/MemorySpectrum.h"

#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/ChosenScalars.h"
#include "Ground/Volume/SampleCopy.h"
#include "Storage/Spectrum/GridSpectrum.h"
#include "Storage/Spectrum/IsovalueProposal.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
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

constexpr std::int64_t SamplesOfProposal = 1 << 21;
constexpr std::size_t BinsOfProposal = 1024;

/// The level at which the grids have few enough vertices together.
int FindProposalLevel(const std::vector<GridGeometry>& grids)
{
  for (int level = 0;; ++level)
  {
    std::int64_t vertices = 0;
    for (const GridGeometry& grid : grids)
    {
      vertices += grid.Coarsen(level).GetNumberOfVertices();
    }
    if (vertices <= SamplesOfProposal || level == 20)
    {
      return level;
    }
  }
}

/// Every 2^level-th sample of a piece. Pieces share the vertices of their faces: those of a high face are
/// left to the next one.
SampleView ThinPiece(SampleView view, const Index3& dimensions, int level)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    view.Box.High[axis] -= dimensions[axis] > 1 ? 1 : 0;
  }
  return Coarsen(view, level);
}

/// Adds the finite samples.
void AddSamples(const SampleView& view, std::vector<double>& samples)
{
  DispatchValueType(view.Type,
    [&](auto zero)
    {
      const VertexBox& box = view.Box;
      for (std::int64_t z = box.Low[2]; z < box.High[2]; ++z)
      {
        for (std::int64_t y = box.Low[1]; y < box.High[1]; ++y)
        {
          for (std::int64_t x = box.Low[0]; x < box.High[0]; ++x)
          {
            const auto sample = static_cast<double>(*view.At<decltype(zero)>({ x, y, z }));
            if (std::isfinite(sample))
            {
              samples.push_back(sample);
            }
          }
        }
      }
    });
}

/// The isovalue that the samples of all ranks propose; NaN if there is none. Collective.
double ProposeOfSamples(Communicator& ranks, const std::vector<double>& samples)
{
  std::vector<std::uint64_t> low = { std::numeric_limits<std::uint64_t>::max() };
  std::vector<std::uint64_t> high = { NotANumberKey };
  for (const double sample : samples)
  {
    low[0] = std::min(low[0], MakeValueKey(sample));
    high[0] = std::max(high[0], MakeValueKey(sample));
  }
  ranks.ReduceMinimum(low);
  ranks.ReduceMaximum(high);
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (low[0] >= high[0])
  {
    return none;
  }
  const auto minimum = MakeValueOfKey<double>(low[0]);
  const auto maximum = MakeValueOfKey<double>(high[0]);
  const double width = maximum / BinsOfProposal - minimum / BinsOfProposal;
  std::vector<std::uint64_t> counted(BinsOfProposal + 1); // the last one of the maximum alone
  for (const double sample : samples)
  {
    const double bin = std::max(0.0, (sample - minimum) / width);
    ++counted[static_cast<std::size_t>(std::min(bin, static_cast<double>(BinsOfProposal)))];
  }
  ranks.ReduceSum(counted);
  std::vector<double> values;
  for (std::size_t bin = 0; bin <= BinsOfProposal; ++bin)
  {
    values.push_back(bin == BinsOfProposal ? maximum : minimum + static_cast<double>(bin) * width);
  }
  return ProposeIsovalue(values, std::vector<double>(counted.begin(), counted.end()))
    .value_or(none);
}

/// scalars: those of each piece.
std::vector<GridSpectrum> MakeGridSpectra(
  const MemoryGrids& samples, const std::vector<SampleView>& scalars, ValueType type, int threads)
{
  std::vector<GridSpectrum> spectra;
  for (std::size_t grid = 0; grid < samples.Grids.size(); ++grid)
  {
    std::vector<SampleView> views;
    for (std::size_t piece = 0; piece < samples.Pieces.size(); ++piece)
    {
      if (samples.Pieces[piece].Grid == grid)
      {
        views.push_back(scalars[piece]);
      }
    }
    MeasuredGrid measured{ samples.Grids[grid] };
    if (const auto& lines = samples.Lines[grid])
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
    ISOSURFACE_ASSIGN_OR_RETURN(auto spectrum, grid.Count(ranks, bins, makeProgress()));
    spectra.push_back(std::move(spectrum));
  }
  return spectra;
}

} // namespace

void MemorySpectrum::Ask(
  MemoryGrids samples, int component, int threads, std::uint64_t samplesAtOnce)
{
  Fingerprint fingerprint;
  fingerprint.AddNumber(static_cast<std::uint64_t>(component));
  fingerprint.AddNumber(samples.ComputeFingerprint());
  this->Same = std::exchange(this->Identity, fingerprint.Get()) == fingerprint.Get();
  this->SamplesAtOnce = samplesAtOnce;
  if (!this->Same)
  {
    this->DropPrepared();
    this->AreCounted = false;
  }
  if (!this->Work)
  {
    this->Samples = std::move(samples);
    this->Component = component;
    this->Threads = threads;
  }
}

Status MemorySpectrum::Prepare(Communicator& ranks, int)
{
  return Attempt(NotCounted,
    [&]
    {
      this->Work = std::make_unique<CollectiveTask>(ranks, NotCounted,
        [this](Communicator& all, const Progress& advance)
        { return this->CountSamples(all, advance); });
      return Status::Ok();
    });
}

Status MemorySpectrum::Count(Communicator& ranks, const Progress& progress)
{
  std::vector<std::uint64_t> are = { this->AreCounted ? 1U : 0U, this->Work ? 1U : 0U };
  ranks.ReduceMinimum(are);
  auto work = std::move(this->Work);
  Status status;
  if (are[0] == 0 && are[1] != 0)
  {
    status = work->Finish(ranks, progress);
  }
  else if (are[0] == 0)
  {
    work.reset(); // another rank has none
    status = this->CountSamples(ranks, progress);
  }
  this->AreCounted = status.IsOk();
  this->Samples = {};
  return status;
}

Status MemorySpectrum::CountSamples(Communicator& ranks, const Progress& progress)
{
  std::vector<ChosenScalars> chosen;
  std::vector<SampleView> scalars;
  const auto choose = [&]
  {
    for (const MemoryPiece& piece : this->Samples.Pieces)
    {
      chosen.emplace_back(piece.Components, this->Component, this->Threads);
      scalars.push_back(chosen.back().GetView(piece.Components));
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotCounted, choose));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto type, FindType(ranks, scalars));
  this->Spectra.clear();
  if (!type)
  {
    return Status::Ok();
  }
  std::vector<GridSpectrum> grids;
  const auto make = [&]
  {
    grids = MakeGridSpectra(this->Samples, scalars, *type, this->Threads);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotCounted, make));
  ISOSURFACE_ASSIGN_OR_RETURN(this->Spectra, CountGrids(ranks, *type, std::move(grids), progress));
  return Status::Ok();
}

Result<double> MemorySpectrum::Propose(Communicator& ranks)
{
  const int level = FindProposalLevel(this->Samples.Grids);
  std::vector<double> samples;
  const auto collect = [&]
  {
    for (const MemoryPiece& piece : this->Samples.Pieces)
    {
      const Index3 dimensions = this->Samples.Grids[piece.Grid].GetDimensions();
      std::vector<SampleView> thinned = piece.Components;
      for (SampleView& view : thinned)
      {
        view = ThinPiece(view, dimensions, level);
      }
      if (!thinned.front().Box.IsEmpty())
      {
        AddSamples(
          ChosenScalars(thinned, this->Component, this->Threads).GetView(thinned), samples);
      }
    }
    return Status::Ok();
  };
  const Status collected = Attempt(NotCounted, collect);
  if (!this->Work)
  {
    this->Samples = {};
  }
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(collected));
  return ProposeOfSamples(ranks, samples);
}

} // namespace isosurface
