// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/GridSpectrum.h"

#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/SampleRange.h"
#include "Storage/Spectrum/BlockActivity.h"
#include "Storage/Spectrum/BlockWorkload.h"

#include <algorithm>

namespace isosurface
{
namespace
{

Status MakeAborted()
{
  return Status(StatusCode::Aborted, "The computation of the spectrum was aborted.");
}

constexpr const char* NotCounted = "the samples of the spectrum cannot be counted";

} // namespace

/// The counts of one thread.
struct GridSpectrum::Counted
{
  BlockWorkload Workload;
  BlockMeasure Measure;
  WorkloadSpectrum Spectrum;
  MeasureSums Sums;
};

GridSpectrum::GridSpectrum(
  const MeasuredGrid& grid, ValueType type, std::vector<SampleView> pieces, int threads)
  : Grid(grid)
  , Type(type)
  , Blocks(grid.Geometry.GetDimensions(), BlockSize)
  , Pieces(std::move(pieces))
  , Threads(std::max(1, threads))
{
}

void GridSpectrum::FindOverlaps()
{
  this->Overlaps.clear();
  const Index3& last = this->Blocks.GetNumberOfBlocksPerAxis();
  for (std::size_t piece = 0; piece < this->Pieces.size(); ++piece)
  {
    const VertexBox& box = this->Pieces[piece].Box;
    if (box.IsEmpty())
    {
      continue;
    }
    Index3 low;
    Index3 high;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      // A vertex on a face belongs to both blocks.
      low[axis] = std::max<std::int64_t>(0, (box.Low[axis] - 1) / BlockSize);
      high[axis] = std::min(last[axis], (box.High[axis] - 1) / BlockSize + 1);
    }
    for (std::int64_t k = low[2]; k < high[2]; ++k)
    {
      for (std::int64_t j = low[1]; j < high[1]; ++j)
      {
        for (std::int64_t i = low[0]; i < high[0]; ++i)
        {
          const std::int64_t block = this->Blocks.GetBlockIndex({ i, j, k });
          const VertexBox part = this->Blocks.GetVertices(block).Intersect(box);
          if (!part.IsEmpty())
          {
            this->Overlaps.push_back({ piece, block, part });
          }
        }
      }
    }
  }
}

Status GridSpectrum::FindOwnRanges(const Progress& progress)
{
  this->FindOverlaps();
  this->Ranges.assign(static_cast<std::size_t>(this->Blocks.GetNumberOfBlocks()), {});
  this->FiniteRange = {};
  std::vector<SampleRange> found(this->Overlaps.size());
  const bool isDone = ParallelFor(
    this->Overlaps.size(), this->Threads,
    [&](std::size_t index, int)
    {
      const Overlap& part = this->Overlaps[index];
      found[index] = FindSampleRange(this->Pieces[part.Piece], part.Box);
    },
    progress);
  if (!isDone)
  {
    return MakeAborted();
  }
  for (std::size_t index = 0; index < found.size(); ++index)
  {
    this->Ranges[static_cast<std::size_t>(this->Overlaps[index].Block)].Add(found[index].All);
    this->FiniteRange.Add(found[index].Finite);
  }
  return Status::Ok();
}

Status GridSpectrum::FindRanges(Communicator& ranks, const Progress& progress)
{
  CommonRanges common;
  const auto find = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(this->FindOwnRanges(progress));
    common.Add(this->FiniteRange);
    for (KeyRange& range : this->Ranges)
    {
      common.Add(range);
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotCounted, find));
  common.Join(ranks);
  return Status::Ok();
}

void GridSpectrum::CountOverlap(const Overlap& part, Counted& counted) const
{
  const KeyRange& range = this->Ranges[static_cast<std::size_t>(part.Block)];
  if (range.Minimum == range.Maximum)
  {
    counted.Measure.CountUniform(this->Type, range.Minimum, part.Box);
    return;
  }
  SampleView view = this->Pieces[part.Piece];
  view.Box = part.Box;
  counted.Workload.Count(view);
  counted.Measure.Count(view);
}

Status GridSpectrum::CountOwn(
  const SpectrumBins& bins, const Progress& progress, std::vector<Counted>& counted) const
{
  counted.reserve(static_cast<std::size_t>(this->Threads));
  for (int thread = 0; thread < this->Threads; ++thread)
  {
    counted.push_back({ BlockWorkload(bins), BlockMeasure(bins, this->Grid), WorkloadSpectrum(bins),
      MeasureSums(bins) });
  }
  const bool isDone = ParallelFor(
    this->Overlaps.size(), this->Threads,
    [&](std::size_t index, int thread)
    { this->CountOverlap(this->Overlaps[index], counted[static_cast<std::size_t>(thread)]); },
    progress);
  if (!isDone)
  {
    return MakeAborted();
  }
  for (Counted& ofThread : counted)
  {
    ofThread.Workload.MoveTo(counted.front().Spectrum);
    ofThread.Measure.MoveTo(counted.front().Sums);
  }
  return Status::Ok();
}

void GridSpectrum::SetActivity(const SpectrumBins& bins, WorkloadSpectrum& spectrum) const
{
  BlockActivity activity(this->Type, bins);
  for (std::size_t block = 0; block < this->Ranges.size(); ++block)
  {
    const VertexBox box = this->Blocks.GetVertices(static_cast<std::int64_t>(block));
    activity.Add(this->Ranges[block],
      static_cast<std::uint64_t>(box.GetNumberOfVertices()) * GetValueSize(this->Type));
  }
  activity.SetActivity(spectrum);
}

Result<WorkloadSpectrum> GridSpectrum::Count(
  Communicator& ranks, const SpectrumBins& bins, const Progress& progress) const
{
  std::vector<Counted> counted;
  std::vector<std::uint64_t> sums;
  const auto count = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(this->CountOwn(bins, progress, counted));
    this->SetActivity(bins, counted.front().Spectrum);
    sums = counted.front().Sums.GetNumbers();
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotCounted, count));
  Counted& sum = counted.front();
  ranks.ReduceSum(sum.Spectrum.Triangles);
  ranks.ReduceSum(sum.Spectrum.ActiveCells);
  ranks.ReduceSum(sums);
  const auto take = [&]
  {
    sum.Sums.SetNumbers(sums);
    sum.Sums.SetMeasures(sum.Spectrum);
    sum.Spectrum.AreaUnit = BlockMeasure::GetAreaUnit(this->Grid.Geometry);
    sum.Spectrum.VolumeUnit = BlockMeasure::GetVolumeUnit(this->Grid.Geometry);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotCounted, take));
  return std::move(sum.Spectrum);
}

} // namespace isosurface
