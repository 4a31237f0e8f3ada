// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/StoredField.h"

#include "Ranks/Query/ProgressiveLevels.h"
#include "Ranks/Query/SurfaceMemory.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/// A surface that grows with an index rests so many times as long as it took to extract and to show.
constexpr int GrowthRest = 2;
/// Its first exact part has about so many at most; each later one is at most twice as deep. So the
/// first is there soon, and the index goes on.
constexpr double FirstPartTriangles = 500'000;

} // namespace

void StoredField::Ask(
  const ExtractionTask& task, const ExtractionBudget& budget, const std::string& sampled)
{
  const bool isSameStep = this->Task.Query.TimeStep == task.Query.TimeStep;
  this->Same = isSameStep && this->GetVolume() == task.Volume;
  const FinishedLayers* const layers = this->Layers ? this->Layers->Finished.get() : nullptr;
  const bool isPlacedElsewhere = layers && layers->CountSlices() > 0 &&
    layers->GetHeader().Grid != task.Volume->GetHeader().Grid;
  this->OfLastSample = isSameStep && !isPlacedElsewhere && this->Sampled == task.Volume->GetPath();
  this->Volume = task.Volume;
  this->Task = task;
  this->Task.Volume = nullptr;
  this->Budget = budget;
  this->AskedSampled = sampled;
}

void StoredField::Forget()
{
  this->DropPrepared();
  this->Layers.reset();
  this->Sampled.clear();
}

//------------------------------------------------------------------------------
// Levels

int StoredField::FindFinestLevel(int level) const
{
  return std::min(level, this->GetVolume()->GetNumberOfLevels() - 1);
}

Result<Field::First> StoredField::FindFirst(Communicator&, int finest)
{
  First first;
  BlockedVolume& volume = *this->GetVolume();
  ISOSURFACE_ASSIGN_OR_RETURN(first.Level, FindFirstLevel(volume, this->Task.Query, finest));
  if (first.Level > finest)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(first.IsDirect, IsDirectSurface(volume, this->Task.Query, finest));
  }
  return first;
}

int StoredField::GetNextLevel(int level, int finest) const
{
  return isosurface::GetNextLevel(*this->GetVolume(), level, finest);
}

Result<int> StoredField::FitLevel(Communicator& ranks, int level)
{
  if (!this->Budget.IsLimited())
  {
    return level;
  }
  QueryStatistics statistics;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto within,
    ChooseLevel(*this->GetVolume(), this->Task.Query, level, this->Budget, this->GetRate(), ranks,
      statistics));
  return within.Level;
}

Result<double> StoredField::EstimateTriangles(int level)
{
  return isosurface::EstimateTriangles(*this->GetVolume(), this->Task.Query, level);
}

double StoredField::EstimateBytes(double triangles) const
{
  return EstimateBytesPerTriangle(this->Task.Request) / this->Task.Query.Ranks * triangles;
}

//------------------------------------------------------------------------------
// Surfaces

ExtractionTask StoredField::MakeTask(std::int64_t slices) const
{
  ExtractionTask task = this->Task;
  task.Volume = this->GetVolume();
  task.Finished = this->Layers ? this->Layers->Finished : nullptr;
  task.FinishedSlices = slices;
  return task;
}

Status StoredField::Extract(Communicator& ranks, int level, ExtractionOutcome& outcome)
{
  const ExtractionTask task = this->MakeTask(this->Layers ? this->Layers->Slices : 0);
  if (this->Budget.IsLimited())
  {
    return this->Contour.ExtractWithinBudget(ranks, this->Budget, task, level, outcome);
  }
  LevelChoice choice;
  choice.Level = level;
  return this->Contour.ExtractAtLevel(task, choice, outcome);
}

Status StoredField::Prepare(Communicator&, int level)
{
  return this->PrepareTask(this->MakeTask(0), level);
}

Status StoredField::PrepareTask(const ExtractionTask& task, int level)
{
  return Attempt("the next surface cannot be prepared",
    [&]
    {
      this->Contour.Prepare(task, level);
      return Status::Ok();
    });
}

//------------------------------------------------------------------------------
// Exact layers of a sample

void StoredField::Growth::Show(bool shows)
{
  if (this->AreShown != shows)
  {
    this->AreShown = shows;
    this->Finished->CountShown(shows ? 1 : -1);
  }
}

bool StoredField::BeginSample(bool isWanted)
{
  if (!isWanted || this->Budget.IsLimited())
  {
    return false;
  }
  if (this->Task.Finished)
  {
    this->Layers = std::make_unique<Growth>(this->Task.Finished);
  }
  // The triangles of a region are not known before it is extracted.
  this->Sampled =
    this->Task.Query.Selection.Region.GetHalfSpaces().empty() ? this->AskedSampled : "";
  return !this->Sampled.empty();
}

Refinement StoredField::Grow(Communicator& ranks, std::size_t triangles, std::uint64_t freeMemory)
{
  Refinement refinement;
  this->DropPrepared(); // all ranks begin, or none does
  // Asked first, so that nothing is added afterwards.
  Growth& growth = *this->Layers;
  const bool hasEnded = growth.Finished->HasEnded();
  const std::int64_t mine = growth.Finished->CountSlices();
  // Each rank extracts the records that it has written, so no piece may be wanted twice or not at all.
  const bool hasPieces = mine == 0 || growth.Finished->GetHeader().IsInPlace() ||
    this->Task.Query.Ranks == ranks.GetSize();
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
    if (!ranks.Agree(this->PrepareTask(this->MakeTask(slices), 0)).IsOk())
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

std::int64_t StoredField::ChooseSlices(
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

bool StoredField::IsGrowthDue(
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

void StoredField::EndGrowth(bool hasFailed)
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
