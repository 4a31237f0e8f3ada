// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/GrowingField.h"

#include "Ground/Volume/BlockSource.h"
#include "Ranks/Query/SurfaceMemory.h"
#include "Ranks/Sharing/QueryPlan.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Contour/SurfaceMerge.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/// The blocks of a source between two slices of vertices, as a source of its own: blocks that are cut
/// there have fewer cells. Gradients take samples beyond. The source must outlive this object.
class SlicedBlocks : public BlockSource
{
public:
  /// The cells from slice `begin` to slice `end` of vertices.
  SlicedBlocks(BlockSource& source, std::int64_t begin, std::int64_t end)
    : Source(source)
    , Begin(begin)
    , End(end)
  {
    for (std::size_t block = 0; block < source.GetNumberOfBlocks(); ++block)
    {
      const VertexBox vertices = source.GetVertices(block);
      if (vertices.Low[2] < end && vertices.High[2] - 1 > begin)
      {
        this->Blocks.push_back(block);
      }
    }
  }
  std::size_t GetNumberOfBlocks() const override { return this->Blocks.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Source.GetLatticeCoordinates(this->Blocks[block]);
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    VertexBox vertices = this->Source.GetVertices(this->Blocks[block]);
    vertices.Low[2] = std::max(vertices.Low[2], this->Begin);
    vertices.High[2] = std::min(vertices.High[2], this->End + 1);
    return vertices;
  }
  ValueType GetValueType() const override { return this->Source.GetValueType(); }
  Result<BlockSamples> Acquire(std::size_t block) override
  {
    auto samples = this->Source.Acquire(this->Blocks[block]);
    if (samples.IsOk())
    {
      samples->Scalars.Box = this->GetVertices(block);
    }
    return samples;
  }

private:
  BlockSource& Source;
  const std::int64_t Begin;
  const std::int64_t End;
  std::vector<std::size_t> Blocks; ///< numbers in the source
};

/// A surface that grows with an index rests so many times as long as it took to extract and to show.
constexpr int GrowthRest = 2;
/// Its first exact part has about so many at most; each later one is at most twice as deep. So the
/// first is there soon, and the index goes on.
constexpr double FirstPartTriangles = 500'000;

/// Where the slices of vertices of a grid are on its third axis.
double FindPlace(const GridGeometry& grid, const GridLines* lines, std::int64_t slice)
{
  if (lines)
  {
    return lines->At(2, slice);
  }
  double place = grid.Spacing[2] * static_cast<double>(grid.Extent[4] + slice);
  for (std::size_t row = 0; row < 3; ++row)
  {
    place += grid.Direction[3 * row + 2] * grid.Origin[row];
  }
  return place;
}

/// Where a surface changes from the finished layers to a sample.
struct Seam
{
  std::int64_t Finished = 0; ///< slices of cells that are taken of the finished layers
  std::int64_t Sample = 0;   ///< the first slice of vertices that is taken of the sample
};

/// The last slice of the sample that lies in the finished ones; these are cut there, too. If the
/// sample ends within them, nothing of it is taken; if it begins behind them, all.
Seam FindSeam(const BlockedVolumeHeader& volume, std::int64_t finished, const GridGeometry& sample,
  const GridLines* sampleLines)
{
  const GridLines* const lines = volume.Lines ? &*volume.Lines : nullptr;
  const double sign = !lines && volume.Grid.Spacing[2] < 0 ? -1 : 1;
  const auto isBehind = [&](std::int64_t slice, std::int64_t of)
  {
    return sign * FindPlace(sample, sampleLines, slice) >
      sign * FindPlace(volume.Grid, lines, of) + 1e-6 * std::abs(volume.Grid.Spacing[2]);
  };
  const std::int64_t last = sample.GetDimensions()[2] - 1;
  Seam seam{ finished, 0 };
  while (seam.Sample < last && !isBehind(seam.Sample + 1, finished))
  {
    ++seam.Sample;
  }
  while (seam.Sample < last && seam.Finished > 0 && !isBehind(seam.Sample, seam.Finished - 1))
  {
    --seam.Finished;
  }
  return seam;
}

/// The first `slices` of the finished layers exactly, and the sample behind them.
Status ExtractWithSeam(FinishedLayers& layers, std::int64_t slices, const ExtractionTask& task,
  int level, ExtractionOutcome& outcome)
{
  BlockedVolume& volume = *task.Volume;
  const BlockedVolumeHeader& finished = layers.GetHeader();
  const GridGeometry geometry = volume.GetHeader().Grid.Coarsen(level);
  const Seam seam = FindSeam(finished, slices, geometry, volume.GetLines(level));
  ISOSURFACE_ASSIGN_OR_RETURN(auto blocks,
    layers.FindBlocks(task.Query, task.Query.Attributes, seam.Finished,
      static_cast<std::size_t>(task.Query.Rank), static_cast<std::size_t>(task.Query.Ranks)));
  SlicedBlocks exactBlocks(*blocks, 0, seam.Finished);
  ContourRequest request = task.Request;
  request.Lines = finished.Lines ? &*finished.Lines : nullptr;
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto exact, ExtractSurface(finished.Grid, exactBlocks, request, task.Threads, task.Advance));
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto plan, PlanQuery(volume, task.Query, level, outcome.Cost.Reading));
  StoredBlockSource source(
    volume, task.Query.TimeStep, task.Query.Variable, level, std::move(plan.Blocks));
  source.SetAttributes(task.Query.Attributes);
  SlicedBlocks sampleBlocks(source, seam.Sample, geometry.GetDimensions()[2] - 1);
  request.Lines = volume.GetLines(level);
  auto sample = ExtractSurface(geometry, sampleBlocks, request, task.Threads,
    [&](double) { return !task.Advance || task.Advance(1); });
  outcome.Cost.Reading.Add(source.GetStatistics());
  ISOSURFACE_RETURN_IF_ERROR(sample.GetStatus());
  ShiftGlobalIds(CountGlobalIds(finished.Grid, task.Request), *sample);
  std::vector<Surface> surfaces;
  surfaces.push_back(std::move(exact));
  surfaces.push_back(std::move(*sample));
  outcome.Extracted = JoinSurfaces(std::move(surfaces));
  outcome.Cost.Reading.ActiveBlocks = outcome.Extracted.NumberOfBlocks;
  return Status::Ok();
}

} // namespace

void GrowingField::Ask(const ExtractionTask& task, const ExtractionBudget& budget,
  std::shared_ptr<FinishedLayers> finished, const std::string& sampled)
{
  const FinishedLayers* const layers = this->Layers ? this->Layers->Finished.get() : nullptr;
  const bool isPlacedElsewhere = layers && layers->CountSlices() > 0 &&
    layers->GetHeader().Grid != task.Volume->GetHeader().Grid;
  this->OfLastSample = this->GetTask().Query.TimeStep == task.Query.TimeStep &&
    !isPlacedElsewhere && this->Sampled == task.Volume->GetPath();
  this->StoredField::Ask(task, budget);
  this->AskedLayers = std::move(finished);
  this->AskedSampled = sampled;
}

void GrowingField::Forget()
{
  this->DropPrepared();
  this->Layers.reset();
  this->Sampled.clear();
}

Status GrowingField::Extract(Communicator& ranks, int level, ExtractionOutcome& outcome)
{
  const std::int64_t slices = this->Layers ? this->Layers->Slices : 0;
  return slices > 0 ? this->Take(level, slices, this->MakeExtraction(slices), outcome)
                    : this->StoredField::Extract(ranks, level, outcome);
}

StoredField::Extraction GrowingField::MakeExtraction(std::int64_t slices) const
{
  return [layers = this->Layers->Finished, slices](
           const ExtractionTask& task, int level, ExtractionOutcome& outcome)
  {
    return RunExtraction(
      task, level, outcome, [&] { return ExtractWithSeam(*layers, slices, task, level, outcome); });
  };
}

void GrowingField::Growth::Show(bool shows)
{
  if (this->AreShown != shows)
  {
    this->AreShown = shows;
    this->Finished->CountShown(shows ? 1 : -1);
  }
}

bool GrowingField::BeginSample(bool isWanted)
{
  if (!isWanted || this->HasBudget())
  {
    return false;
  }
  if (this->AskedLayers)
  {
    this->Layers = std::make_unique<Growth>(this->AskedLayers);
  }
  // The triangles of a region are not known before it is extracted.
  this->Sampled =
    this->GetTask().Query.Selection.Region.GetHalfSpaces().empty() ? this->AskedSampled : "";
  return !this->Sampled.empty();
}

Refinement GrowingField::Grow(Communicator& ranks, std::size_t triangles, std::uint64_t freeMemory)
{
  Refinement refinement;
  this->DropPrepared(); // all ranks begin, or none does
  // Asked first, so that nothing is added afterwards.
  Growth& growth = *this->Layers;
  const bool hasEnded = growth.Finished->HasEnded();
  const std::int64_t mine = growth.Finished->CountSlices();
  // Each rank extracts the records that it has written, so no piece may be wanted twice or not at all.
  const bool hasPieces = mine == 0 || growth.Finished->GetHeader().IsInPlace() ||
    this->GetTask().Query.Ranks == ranks.GetSize();
  std::vector<std::uint64_t> all = { hasEnded ? 1U : 0U, static_cast<std::uint64_t>(mine),
    hasPieces ? 1U : 0U };
  ranks.ReduceMinimum(all);
  const auto finished = static_cast<std::int64_t>(all[1]);
  if (all[2] == 0)
  {
    return refinement;
  }
  if (finished == 0)
  {
    refinement.Stage = all[0] != 0 ? RefinementStage::None : RefinementStage::Growing;
    return refinement;
  }
  refinement.Stage = RefinementStage::Growing;
  const std::int64_t slices = this->ChooseSlices(ranks, finished, triangles, refinement);
  if (this->IsGrowthDue(ranks, slices, freeMemory, refinement))
  {
    growth.Show(true);
    growth.NextSlices = slices;
    growth.Begin = Clock::now();
    if (!ranks.Agree(this->PrepareVariant(0, slices, this->MakeExtraction(slices))).IsOk())
    {
      this->DropPrepared();
      growth.Due = Clock::now() + std::chrono::seconds(1);
    }
  }
  else if (all[0] != 0 && finished == growth.Slices)
  {
    refinement.Stage = RefinementStage::None;
  }
  return refinement;
}

std::int64_t GrowingField::ChooseSlices(
  Communicator& ranks, std::int64_t finished, std::size_t triangles, Refinement& refinement) const
{
  const BlockedVolumeHeader& whole = this->Layers->Finished->GetHeader();
  const auto all = static_cast<double>(whole.Grid.GetDimensions()[2] - 1);
  const std::int64_t before = this->Layers->Slices;
  refinement.Share = static_cast<double>(before) / all;
  const auto shown = static_cast<double>(ranks.Sum(triangles));
  if (before > 0)
  {
    const std::int64_t slices = std::min(finished, 2 * before);
    refinement.Triangles = shown * static_cast<double>(slices) / static_cast<double>(before);
    return slices;
  }
  const auto vertices = [](const BlockedVolumeHeader& header)
  { return static_cast<double>(header.Grid.GetNumberOfVertices()); };
  const double perSlice =
    shown / all * std::pow(vertices(whole) / vertices(this->GetVolume()->GetHeader()), 2.0 / 3);
  const auto slices = std::min(finished,
    std::max<std::int64_t>(whole.BlockSize,
      static_cast<std::int64_t>(std::min(all, FirstPartTriangles / std::max(1.0, perSlice)))));
  refinement.Triangles = shown + perSlice * static_cast<double>(slices);
  return slices;
}

bool GrowingField::IsGrowthDue(
  Communicator& ranks, std::int64_t slices, std::uint64_t freeMemory, Refinement& refinement)
{
  Growth& growth = *this->Layers;
  const Clock::time_point now = Clock::now();
  if (growth.HasGrown)
  {
    growth.HasGrown = false;
    growth.Due = now + GrowthRest * (now - growth.Begin);
  }
  refinement.Bytes = this->EstimateBytes(refinement.Triangles);
  std::vector<std::uint64_t> all = { now < growth.Due ? 0U : 1U, freeMemory };
  ranks.ReduceMinimum(all);
  refinement.FreeBytes = static_cast<double>(all[1]);
  const bool fits =
    refinement.FreeBytes <= 0 || refinement.Bytes <= UsableMemoryShare * refinement.FreeBytes;
  const bool isMore = slices > growth.Slices;
  if (!fits && isMore)
  {
    growth.Show(false); // a larger sample shows more
  }
  return isMore && all[0] != 0 && fits;
}

void GrowingField::EndGrowth(bool hasFailed)
{
  Growth& growth = *this->Layers;
  if (hasFailed)
  {
    this->DropPrepared();
    growth.HasFailed = true;
    growth.Show(false);
  }
  else
  {
    growth.Slices = growth.NextSlices;
    growth.HasGrown = true;
  }
}

} // namespace isosurface
