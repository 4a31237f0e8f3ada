// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/GrowingField.h"

#include "Ground/Base/Address.h"
#include "Ground/Base/ReadingStop.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BlockSource.h"
#include "Ground/Volume/VertexPlaces.h"
#include "Ranks/Query/SurfaceMemory.h"
#include "Ranks/Sharing/QueryPlan.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Contour/SurfaceMerge.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/// The cells of a source's blocks in a box of vertices, as a source of its own: blocks that are cut there
/// have fewer cells. Gradients take samples beyond. The source must outlive this object.
class CutBlocks : public BlockSource
{
public:
  CutBlocks(BlockSource& source, const VertexBox& box)
    : Source(source)
    , Box(box)
  {
    for (std::size_t block = 0; block < source.GetNumberOfBlocks(); ++block)
    {
      const Index3 vertices = source.GetVertices(block).Intersect(box).GetSize();
      if (*std::min_element(vertices.begin(), vertices.end()) > 1)
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
    return this->Source.GetVertices(this->Blocks[block]).Intersect(this->Box);
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
  const VertexBox Box;
  std::vector<std::size_t> Blocks; ///< numbers in the source
};

/// A surface that grows with an index rests so many times as long as it took to extract and to show.
constexpr int GrowthRest = 2;
/// Its first exact part has about so many at most; each later one is at most twice as deep. So the
/// first is there soon, and the index goes on.
constexpr double FirstPartTriangles = 500'000;
/// The samples of the boxes around what is looked at, one after another: of a source at an address, which is slow; of
/// another one the last alone, and no more than a part of the volume, since the index reads them again.
constexpr std::array<double, 3> BoxBytes = { 16 * 0x1p20, 64 * 0x1p20, 256 * 0x1p20 };
constexpr double LocalShare = 1.0 / 16;
/// The share of the cache of blocks that a box may take.
constexpr double CachedShare = 1.0 / 2;
/// Chunks of an address are read by so many threads.
constexpr int ReadingThreads = 16;
/// Points of a surface that tell where it is.
constexpr std::size_t KeptPoints = 20'000;
/// What is looked at is in the middle of the view: within such a share of the radius that is seen.
constexpr std::array<double, 3> MiddleShares = { 0.1, 0.3, 1 };

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

/// The boxes of the cells of a box of vertices that are not in another one.
std::vector<VertexBox> FindCellsBeside(VertexBox box, const VertexBox& hole)
{
  const VertexBox common = box.Intersect(hole);
  const Index3 size = common.GetSize();
  std::vector<VertexBox> beside;
  if (*std::min_element(size.begin(), size.end()) < 2)
  {
    return { box };
  }
  for (std::size_t axis = 3; axis-- > 0;)
  {
    VertexBox before = box;
    before.High[axis] = common.Low[axis] + 1;
    VertexBox behind = box;
    behind.Low[axis] = common.High[axis] - 1;
    for (const VertexBox& part : { before, behind })
    {
      if (part.High[axis] - part.Low[axis] > 1)
      {
        beside.push_back(part);
      }
    }
    box.Low[axis] = common.Low[axis];
    box.High[axis] = common.High[axis];
  }
  return beside;
}

/// The first `slices` of the finished layers and a box exactly, and the sample beyond them.
Status ExtractWithSeams(FinishedLayers& layers, std::int64_t slices, const SightedBox& box,
  const ExtractionTask& task, int level, ExtractionOutcome& outcome)
{
  BlockedVolume& volume = *task.Volume;
  const BlockedVolumeHeader& finished = layers.GetHeader();
  const GridGeometry geometry = volume.GetHeader().Grid.Coarsen(level);
  const Seam seam =
    slices > 0 ? FindSeam(finished, slices, geometry, volume.GetLines(level)) : Seam();
  const auto rank = static_cast<std::size_t>(task.Query.Rank);
  const auto ranks = static_cast<std::size_t>(task.Query.Ranks);
  ContourRequest request = task.Request;
  request.Lines = finished.Lines ? &*finished.Lines : nullptr;
  std::vector<Surface> surfaces;
  const auto extract = [&](const GridGeometry& grid, BlockSource& blocks,
                         const Progress& advance) -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto surface, ExtractSurface(grid, blocks, request, task.Threads, advance));
    surfaces.push_back(std::move(surface));
    return Status::Ok();
  };
  if (seam.Finished > 0)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto blocks,
      layers.FindBlocks(task.Query, task.Query.Attributes, seam.Finished, rank, ranks));
    VertexBox part{ { 0, 0, 0 }, finished.Grid.GetDimensions() };
    part.High[2] = seam.Finished + 1;
    CutBlocks exact(*blocks, part);
    ISOSURFACE_RETURN_IF_ERROR(extract(finished.Grid, exact, task.Advance));
  }
  VertexBox sighted = box.Exact;
  sighted.Low[2] = std::max(sighted.Low[2], seam.Finished);
  if (!sighted.IsEmpty() && sighted.GetSize()[2] > 1)
  {
    const int threads =
      IsAddress(finished.TimeSteps.back().Source->AbsolutePath) ? ReadingThreads : task.Threads;
    ISOSURFACE_ASSIGN_OR_RETURN(auto blocks,
      layers.FindBox(task.Query, task.Query.Attributes, sighted, rank, ranks, threads));
    request.KnownSamples = sighted;
    ISOSURFACE_RETURN_IF_ERROR(extract(finished.Grid, *blocks, task.Advance));
    request.KnownSamples = task.Request.KnownSamples;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto plan, PlanQuery(volume, task.Query, level, outcome.Cost.Reading));
  request.Lines = volume.GetLines(level);
  const std::size_t ofSample = surfaces.size();
  const VertexBox behind{ { 0, 0, seam.Sample }, geometry.GetDimensions() };
  for (const VertexBox& part : FindCellsBeside(behind, box.Sampled))
  {
    StoredBlockSource source(volume, task.Query.TimeStep, task.Query.Variable, level, plan.Blocks);
    source.SetAttributes(task.Query.Attributes);
    CutBlocks blocks(source, part);
    ISOSURFACE_RETURN_IF_ERROR(
      extract(geometry, blocks, [&](double) { return !task.Advance || task.Advance(1); }));
    outcome.Cost.Reading.Add(source.GetStatistics());
  }
  const std::int64_t ids = CountGlobalIds(finished.Grid, task.Request);
  std::for_each(surfaces.begin() + static_cast<std::ptrdiff_t>(ofSample), surfaces.end(),
    [&](Surface& surface) { ShiftGlobalIds(ids, surface); });
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
  this->Points.clear();
  this->Sampled.clear();
}

Status GrowingField::Extract(Communicator& ranks, int level, ExtractionOutcome& outcome)
{
  const ExactPart part = this->Layers ? this->Layers->Shown : ExactPart();
  const Status status = part.Number > 0
    ? this->Take(level, part.Number, this->MakeExtraction(part), outcome)
    : this->StoredField::Extract(ranks, level, outcome);
  this->KeepPoints(outcome.Extracted);
  return status;
}

StoredField::Extraction GrowingField::MakeExtraction(const ExactPart& part) const
{
  return [layers = this->Layers->Finished, part](
           const ExtractionTask& task, int level, ExtractionOutcome& outcome)
  {
    const Progress look = [&](double share)
    { return layers->MayRead() && (!task.Advance || task.Advance(share)); };
    const ReadingStop stop(look);
    return RunExtraction(task, level, outcome,
      [&] { return ExtractWithSeams(*layers, part.Slices, part.Box, task, level, outcome); });
  };
}

void GrowingField::KeepPoints(const Surface& surface)
{
  const std::size_t step = 1 + surface.NumberOfPoints / KeptPoints;
  this->Points.clear();
  for (std::size_t point = 0; this->Layers && point < surface.NumberOfPoints; point += step)
  {
    const Vector3 place = surface.GetPoint(point);
    this->Points.push_back({ place[0], place[1], place[2] });
  }
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

double GrowingField::FindDistance(Communicator& ranks, const Sight& sight) const
{
  constexpr double none = std::numeric_limits<double>::max();
  std::array<double, MiddleShares.size()> nearest{};
  nearest.fill(none);
  for (const std::array<double, 3>& point : this->Points)
  {
    double along = 0;
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double offset = point[axis] - sight.Eye[axis];
      along += offset * sight.Direction[axis];
      square += offset * offset;
    }
    const double aside = std::sqrt(std::max(0.0, square - along * along));
    for (std::size_t share = 0; along > 0 && share < MiddleShares.size(); ++share)
    {
      if (aside <= MiddleShares[share] * sight.FindRadius(along))
      {
        nearest[share] = std::min(nearest[share], along);
      }
    }
  }
  // The bits of positive numbers are in their order.
  std::vector<std::uint64_t> all(nearest.size());
  std::memcpy(all.data(), nearest.data(), sizeof(nearest));
  ranks.ReduceMinimum(all);
  std::memcpy(nearest.data(), all.data(), sizeof(nearest));
  const auto found =
    std::find_if(nearest.begin(), nearest.end(), [&](double distance) { return distance < none; });
  if (found != nearest.end())
  {
    return *found;
  }
  // Nothing is there. The middle of the volume is.
  const BlockedVolumeHeader& whole = this->Layers->Finished->GetHeader();
  const VertexPlaces places(whole.Grid, whole.Lines ? &*whole.Lines : nullptr);
  const Index3 size = whole.Grid.GetDimensions();
  const auto half = [&](std::size_t axis) { return static_cast<double>(size[axis] - 1) / 2; };
  const std::array<double, 3> middle = places.FindPoint({ half(0), half(1), half(2) });
  double along = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    along += (middle[axis] - sight.Eye[axis]) * sight.Direction[axis];
  }
  return std::max(0.0, along);
}

std::optional<SightedBox> GrowingField::FindNextBox(Communicator& ranks)
{
  Growth& growth = *this->Layers;
  const std::optional<Sight> sight = growth.Finished->GetSight();
  const bool isThere = ranks.All(sight.has_value());
  if (!isThere)
  {
    return std::nullopt;
  }
  if (!growth.Sighted || !(growth.Sighted->Along == *sight))
  {
    growth.Sighted = Look{ *sight, this->FindDistance(ranks, *sight), 0 };
  }
  const BlockedVolumeHeader& whole = growth.Finished->GetHeader();
  const ArrayVariables variables = whole.GetVariables();
  double vertexBytes = 0;
  std::vector<std::size_t> arrays = this->GetTask().Query.Attributes;
  arrays.push_back(variables[this->GetTask().Query.Variable].Array);
  for (const std::size_t array : arrays)
  {
    vertexBytes +=
      variables.GetComponents(array) * static_cast<double>(GetValueSize(whole.Arrays[array].Type));
  }
  const bool isRemote = IsAddress(whole.TimeSteps.back().Source->AbsolutePath);
  const double most = std::min(
    CachedShare * static_cast<double>(ranks.Minimum(BlockCache::GetProcessCache()->GetBudget())),
    isRemote ? BoxBytes.back()
             : LocalShare * vertexBytes * static_cast<double>(whole.Grid.GetNumberOfVertices()));
  Look& look = *growth.Sighted;
  look.Boxes = isRemote ? look.Boxes : std::max(look.Boxes, BoxBytes.size() - 1);
  for (; look.Boxes < BoxBytes.size(); ++look.Boxes)
  {
    const auto vertices =
      static_cast<std::int64_t>(std::min(most, BoxBytes[look.Boxes]) / vertexBytes);
    const SightedBox box =
      FindSightedBox(whole, look.Along, look.Distance, this->GetTask().Query.Selection.Region,
        vertices, this->GetVolume()->GetHeader().Grid, this->GetVolume()->GetLines(0));
    const bool isShown = box.Exact.IsEmpty() || box == growth.Shown.Box ||
      growth.Shown.Slices >= box.Exact.High[2] - 1;
    if (!isShown)
    {
      return box;
    }
  }
  return std::nullopt;
}

double GrowingField::FindShare(const ExactPart& part) const
{
  const Index3 size = this->Layers->Finished->GetHeader().Grid.GetDimensions();
  const auto layer = static_cast<double>(size[0] * size[1]);
  VertexBox box = part.Box.Exact;
  box.Low[2] = std::max(box.Low[2], part.Slices);
  return (layer * static_cast<double>(part.Slices) +
           static_cast<double>(box.GetNumberOfVertices())) /
    (layer * static_cast<double>(size[2] - 1));
}

void GrowingField::PrepareNext(Communicator& ranks)
{
  Growth& growth = *this->Layers;
  growth.Next.Number = growth.Shown.Number + 1;
  growth.Begin = Clock::now();
  if (!ranks.Agree(this->PrepareVariant(0, growth.Next.Number, this->MakeExtraction(growth.Next)))
         .IsOk())
  {
    this->DropPrepared();
    growth.Due = Clock::now() + std::chrono::seconds(1);
  }
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
    hasPieces ? 1U : 0U, growth.Finished->HasBoxes() ? 1U : 0U };
  ranks.ReduceMinimum(all);
  const auto finished = static_cast<std::int64_t>(all[1]);
  if (all[2] == 0)
  {
    return refinement;
  }
  if (all[3] != 0)
  {
    const auto box = this->FindNextBox(ranks);
    growth.Next = { 0, growth.Shown.Slices, box.value_or(SightedBox()) };
    const auto shown = static_cast<double>(ranks.Sum(triangles));
    refinement.Triangles = shown +
      this->FindExactTriangles(shown) *
        std::pow(this->FindShare({ 0, 0, growth.Next.Box }), 2.0 / 3);
    if (box && this->FitsMemory(ranks, freeMemory, refinement))
    {
      refinement.Stage = RefinementStage::Growing;
      refinement.Share = this->FindShare(growth.Shown);
      this->PrepareNext(ranks);
      return refinement;
    }
  }
  if (finished == 0)
  {
    refinement.Stage = all[0] != 0 ? RefinementStage::None : RefinementStage::Growing;
    refinement.Share = growth.Shown.Number > 0 ? this->FindShare(growth.Shown) : 0;
    return refinement;
  }
  refinement.Stage = RefinementStage::Growing;
  const std::int64_t slices = this->ChooseSlices(ranks, finished, triangles, refinement);
  if (this->IsGrowthDue(ranks, slices, freeMemory, refinement))
  {
    growth.Show(true);
    growth.Next = { 0, slices, growth.Shown.Box };
    this->PrepareNext(ranks);
  }
  else if (all[0] != 0 && finished == growth.Shown.Slices)
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
  const std::int64_t before = this->Layers->Shown.Slices;
  refinement.Share = this->FindShare(this->Layers->Shown);
  const auto shown = static_cast<double>(ranks.Sum(triangles));
  if (before > 0)
  {
    const std::int64_t slices = std::min(finished, 2 * before);
    refinement.Triangles = shown * static_cast<double>(slices) / static_cast<double>(before);
    return slices;
  }
  const double perSlice = this->FindExactTriangles(shown) / all;
  const auto slices = std::min(finished,
    std::max<std::int64_t>(whole.BlockSize,
      static_cast<std::int64_t>(std::min(all, FirstPartTriangles / std::max(1.0, perSlice)))));
  refinement.Triangles = shown + perSlice * static_cast<double>(slices);
  return slices;
}

double GrowingField::FindExactTriangles(double ofSample) const
{
  const auto vertices = [](const BlockedVolumeHeader& header)
  { return static_cast<double>(header.Grid.GetNumberOfVertices()); };
  return ofSample *
    std::pow(
      vertices(this->Layers->Finished->GetHeader()) / vertices(this->GetVolume()->GetHeader()),
      2.0 / 3);
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
  const bool isDue = ranks.All(now >= growth.Due);
  const bool fits = this->FitsMemory(ranks, freeMemory, refinement);
  const bool isMore = slices > growth.Shown.Slices;
  if (!fits && isMore)
  {
    growth.Show(false); // a larger sample shows more
  }
  return isMore && isDue && fits;
}

bool GrowingField::FitsMemory(
  Communicator& ranks, std::uint64_t freeMemory, Refinement& refinement) const
{
  refinement.Bytes = this->EstimateBytes(refinement.Triangles);
  refinement.FreeBytes = static_cast<double>(ranks.Minimum(freeMemory));
  return refinement.FreeBytes <= 0 || refinement.Bytes <= UsableMemoryShare * refinement.FreeBytes;
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
    growth.Shown = growth.Next;
    growth.HasGrown = true;
  }
}

} // namespace isosurface
