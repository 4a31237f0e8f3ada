// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/VolumeRefinement.h"

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

VolumeRefinement::VolumeRefinement(std::function<std::uint64_t()> findFreeMemory)
  : FindFreeMemory(std::move(findFreeMemory))
{
}

void VolumeRefinement::Forget()
{
  this->DropPrepared();
  this->Last = {};
  this->Next = {};
}

//------------------------------------------------------------------------------
// A surface

Result<VolumeRefinement::Choice> VolumeRefinement::Begin(Communicator& ranks, ExtractionTask& task,
  const std::string& sampled, const RefinementRequest& wanted)
{
  Pass& pass = this->Last;
  const bool isOfChange =
    pass.Wanted.Change == wanted.Change && pass.Task.Query.TimeStep == task.Query.TimeStep;
  const bool isSame = isOfChange && pass.Volume.lock() == task.Volume;
  const bool mayStay = isOfChange && pass.Shown && pass.Sampled == task.Volume->GetPath();
  std::vector<std::uint64_t> sums = { isSame ? 0U : 1U, mayStay ? 1U : 0U, pass.Triangles };
  ranks.ReduceSum(sums);
  if (sums[0] != 0)
  {
    this->Forget();
    pass.Wanted = wanted;
    const bool mayAllStay = sums[1] == static_cast<std::uint64_t>(ranks.GetSize());
    const Status chosen = Attempt("the isosurface cannot be extracted",
      [&] { return this->ChooseFirst(task, sampled, mayAllStay ? sums[2] : 0); });
    const auto level = static_cast<std::uint64_t>(pass.Level);
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(chosen,
      { MakeCommonFile(
        task.Volume->GetPath(), 4 * level + (pass.IsDirect ? 2 : 0) + (pass.Stays ? 1 : 0)) }));
    pass.Volume = task.Volume;
  }
  task.Finished = pass.Task.Finished;
  task.FinishedSlices = pass.Task.FinishedSlices;
  pass.Task = task;
  pass.Task.Volume = nullptr;
  pass.Task.Advance = {};
  pass.Task.Sharing = nullptr;
  pass.IsFinal = pass.Level <= pass.Wanted.Level;
  return Choice{ pass.Level, !pass.Sampled.empty(), pass.Stays };
}

Status VolumeRefinement::ChooseFirst(
  const ExtractionTask& task, const std::string& sampled, std::uint64_t shown)
{
  Pass& pass = this->Last;
  const RefinementRequest& wanted = pass.Wanted;
  BlockedVolume& volume = *task.Volume;
  const int finest = std::min(wanted.Level, volume.GetNumberOfLevels() - 1);
  pass.Level = finest;
  if (wanted.IsProgressive || wanted.MayBeCoarse)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto first, FindFirstLevel(volume, task.Query, finest));
    pass.Level = first;
    // Scripts ask for the levels one by one; a window shows no more than a user can see.
    if (!wanted.IsProgressive && first > finest)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(pass.IsDirect, IsDirectSurface(volume, task.Query, finest));
    }
  }
  if (!wanted.MayBeCoarse || wanted.Level > 0 || wanted.FindsIslands || wanted.Budget.IsLimited())
  {
    return Status::Ok();
  }
  pass.Task.Finished = task.Finished;
  // The triangles of a region are not known before it is extracted.
  pass.Sampled = task.Query.Selection.Region.GetHalfSpaces().empty() ? sampled : "";
  return shown > 0 ? this->ChooseLevelThatStays(task, shown) : Status::Ok();
}

/// Has the surface of a sample stay until there is a finer one.
Status VolumeRefinement::ChooseLevelThatStays(const ExtractionTask& task, std::uint64_t shown)
{
  Pass& pass = this->Last;
  for (int level = pass.Level;; level = this->GetNextLevel(*task.Volume))
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto triangles, EstimateTriangles(*task.Volume, task.Query, level));
    if (level == 0 || triangles > static_cast<double>(shown))
    {
      return Status::Ok(); // it follows
    }
    pass.Stays = true;
    pass.Level = level;
    pass.Triangles = static_cast<std::size_t>(triangles / task.Query.Ranks);
  }
}

Status VolumeRefinement::Extract(
  Communicator& ranks, const ExtractionTask& task, ExtractionOutcome& outcome)
{
  Pass& pass = this->Last;
  if (!pass.Wanted.Budget.IsLimited())
  {
    LevelChoice choice;
    choice.Level = pass.Level;
    return this->Contour.ExtractAtLevel(task, choice, outcome);
  }
  ISOSURFACE_RETURN_IF_ERROR(
    this->Contour.ExtractWithinBudget(ranks, pass.Wanted.Budget, task, pass.Level, outcome));
  // What forbids this level forbids finer ones, too.
  pass.IsFinal = pass.IsFinal || outcome.Cost.Level > pass.Level;
  return Status::Ok();
}

void VolumeRefinement::SetShown(bool shown, std::size_t triangles)
{
  this->Last.Shown = shown;
  this->Last.Stays = this->Last.Stays && shown;
  if (!this->Last.Stays)
  {
    this->Last.Triangles = triangles;
  }
}

//------------------------------------------------------------------------------
// The next surface

int VolumeRefinement::GetNextLevel(const BlockedVolume& volume) const
{
  const int finest = std::min(this->Last.Wanted.Level, volume.GetNumberOfLevels() - 1);
  return this->Last.IsDirect ? finest : isosurface::GetNextLevel(volume, this->Last.Level, finest);
}

bool VolumeRefinement::MayRefine(std::uint64_t change) const
{
  const Pass& pass = this->Last;
  return !pass.IsFinal && pass.Shown && pass.Wanted.Change == change && !pass.Volume.expired();
}

bool VolumeRefinement::MayGrow(std::uint64_t change) const
{
  const Pass& pass = this->Last;
  return pass.Task.Finished && !pass.GrowthEnded && pass.Level == 0 && pass.Shown &&
    pass.Wanted.Change == change && !pass.Volume.expired();
}

bool VolumeRefinement::Refine(std::uint64_t change)
{
  Pass& pass = this->Last;
  if (this->MayGrow(change) && this->Contour.GetPrepared())
  {
    pass.Task.FinishedSlices = this->Contour.GetPrepared()->GetTask().FinishedSlices;
    pass.HasGrown = true;
  }
  else if (this->MayRefine(change))
  {
    pass.Level = this->GetNextLevel(*pass.Volume.lock());
    pass.Stays = false;
  }
  else
  {
    return false;
  }
  pass.Shown = false;
  return true;
}

VolumeRefinement::Preparation VolumeRefinement::Wait(
  Communicator& ranks, double seconds, std::uint64_t change)
{
  const bool grows = this->MayGrow(change);
  const bool refines = this->MayRefine(change);
  BackgroundExtraction* const extraction = this->Contour.GetPrepared();
  const bool isReady = extraction && (grows || refines) && extraction->Wait(seconds);
  const double share = extraction ? extraction->GetProgress() : 0;
  std::vector<std::uint64_t> all = { grows ? 1U : 0U, refines ? 1U : 0U, extraction ? 1U : 0U,
    isReady ? 1U : 0U, isReady && !extraction->GetStatus().IsOk() ? 0U : 1U,
    static_cast<std::uint64_t>(share * Millionths) };
  ranks.ReduceMinimum(all);
  return { all[0] != 0, all[1] != 0, all[2] != 0, all[3] != 0, all[4] == 0,
    static_cast<double>(all[5]) / Millionths };
}

Refinement VolumeRefinement::Prepare(Communicator& ranks, double seconds, std::uint64_t change)
{
  Refinement& next = this->Next;
  Preparation prepared = this->Wait(ranks, seconds, change);
  if (prepared.Grows)
  {
    if (!prepared.Exists)
    {
      next = this->BeginGrowth(ranks);
    }
    else if (prepared.HasFailed)
    {
      // What is shown stays. Indexing tells what is at fault, or a query of the index.
      this->DropPrepared();
      this->Last.GrowthEnded = true;
      this->Last.AreShown = nullptr;
      next = {};
    }
    else if (prepared.IsReady)
    {
      next.Stage = RefinementStage::Ready;
    }
    return next;
  }
  if (!prepared.Refines)
  {
    this->DropPrepared();
    next = {};
    return next;
  }
  if (!prepared.Exists)
  {
    if (!ranks.Agree(this->BeginLevel(ranks)).IsOk())
    {
      // Refine extracts without preparation, and tells of the error.
      this->DropPrepared();
      next.Stage = RefinementStage::Ready;
    }
    if (next.Stage != RefinementStage::Working)
    {
      return next;
    }
    prepared = this->Wait(ranks, seconds, change);
  }
  next.Stage = prepared.IsReady ? RefinementStage::Ready : RefinementStage::Working;
  next.Share = prepared.Share;
  return next;
}

//------------------------------------------------------------------------------
// A finer level

Status VolumeRefinement::BeginLevel(Communicator& ranks)
{
  const Pass& pass = this->Last;
  const std::shared_ptr<BlockedVolume> volume = pass.Volume.lock();
  const int finest = std::min(pass.Wanted.Level, volume->GetNumberOfLevels() - 1);
  int level = this->GetNextLevel(*volume);
  if (pass.Wanted.Budget.IsLimited())
  {
    QueryStatistics statistics;
    ISOSURFACE_ASSIGN_OR_RETURN(const auto within,
      ChooseLevel(
        *volume, pass.Task.Query, level, pass.Wanted.Budget, this->GetRate(), ranks, statistics));
    level = within.Level;
  }
  this->Next.ShownLevel = pass.Level;
  this->Next.NextLevel = level;
  this->Next.FinalLevel = finest;
  bool isSizeAccepted = false;
  ISOSURFACE_RETURN_IF_ERROR(this->FindFittingLevel(ranks, *volume, isSizeAccepted));
  // The ranks wait together for a surface that each extracts, or none does.
  const bool isWanted = this->Next.FittingLevel <= level || isSizeAccepted;
  this->Next.Stage = isWanted ? RefinementStage::Working : RefinementStage::TooLarge;
  return isWanted ? this->BeginExtraction(volume, level, 0) : Status::Ok();
}

Status VolumeRefinement::FindFittingLevel(
  Communicator& ranks, BlockedVolume& volume, bool& isSizeAccepted)
{
  const Pass& pass = this->Last;
  Refinement& next = this->Next;
  std::vector<double> estimates; ///< from the next level to the one that is shown
  Status status;
  for (int level = next.NextLevel; level <= pass.Level && status.IsOk(); ++level)
  {
    const auto triangles = EstimateTriangles(volume, pass.Task.Query, level);
    status = triangles.GetStatus();
    estimates.push_back(triangles.IsOk() ? *triangles : 0);
  }
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(status));
  std::vector<std::uint64_t> limits = { this->FindFreeMemory(), pass.SizeAccepted ? 1U : 0U };
  ranks.ReduceMinimum(limits);
  const std::uint64_t shown = ranks.Sum(pass.Triangles);
  isSizeAccepted = limits[1] != 0;
  // A region has a part of the triangles that spectra count: that of the shown surface.
  const double part =
    estimates.back() > 0 ? std::min(1.0, static_cast<double>(shown) / estimates.back()) : 1;
  const double bytesPerTriangle =
    EstimateBytesPerTriangle(pass.Task.Request) / pass.Task.Query.Ranks;
  std::vector<double> bytes;
  bytes.reserve(estimates.size());
  for (const double triangles : estimates)
  {
    bytes.push_back(bytesPerTriangle * part * triangles);
  }
  next.Triangles = part * estimates.front();
  next.Bytes = bytes.front();
  next.FreeBytes = static_cast<double>(limits[0]);
  next.FittingLevel = next.NextLevel + static_cast<int>(FindFittingSurface(bytes, next.FreeBytes));
  return Status::Ok();
}

Status VolumeRefinement::BeginExtraction(
  const std::shared_ptr<BlockedVolume>& volume, int level, std::int64_t finishedSlices)
{
  return Attempt("the next surface cannot be prepared",
    [&]
    {
      ExtractionTask task = this->Last.Task;
      task.Volume = volume;
      task.FinishedSlices = finishedSlices;
      this->Contour.Prepare(std::move(task), level);
      return Status::Ok();
    });
}

//------------------------------------------------------------------------------
// Exact layers of a sample

Refinement VolumeRefinement::BeginGrowth(Communicator& ranks)
{
  Pass& pass = this->Last;
  Refinement refinement;
  this->DropPrepared(); // all ranks begin, or none does
  // Asked first, so that nothing is added afterwards.
  const FinishedLayers& layers = *pass.Task.Finished;
  const bool hasEnded = layers.HasEnded();
  const std::int64_t mine = layers.CountSlices();
  // Each rank extracts the records that it has written, so no piece may be wanted twice or not at all.
  const bool hasPieces =
    mine == 0 || layers.GetHeader().IsInPlace() || pass.Task.Query.Ranks == ranks.GetSize();
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
  const std::int64_t slices = this->ChooseFinishedSlices(ranks, finished, refinement);
  if (this->IsGrowthDue(ranks, slices, refinement))
  {
    pass.AreShown = pass.Task.Finished->Show();
    pass.GrowthBegin = Clock::now();
    if (!ranks.Agree(this->BeginExtraction(pass.Volume.lock(), 0, slices)).IsOk())
    {
      this->DropPrepared();
      pass.GrowthDue = Clock::now() + std::chrono::seconds(1);
    }
  }
  else if (all[0] != 0 && finished == pass.Task.FinishedSlices)
  {
    refinement.Stage = RefinementStage::None;
  }
  return refinement;
}

std::int64_t VolumeRefinement::ChooseFinishedSlices(
  Communicator& ranks, std::int64_t finished, Refinement& refinement) const
{
  const Pass& pass = this->Last;
  const BlockedVolumeHeader& whole = pass.Task.Finished->GetHeader();
  const auto all = static_cast<double>(whole.Grid.GetDimensions()[2] - 1);
  const std::int64_t before = pass.Task.FinishedSlices;
  refinement.Share = static_cast<double>(before) / all;
  const auto shown = static_cast<double>(ranks.Sum(pass.Triangles));
  if (before > 0)
  {
    const std::int64_t slices = std::min(finished, 2 * before);
    refinement.Triangles = shown * static_cast<double>(slices) / static_cast<double>(before);
    return slices;
  }
  const auto vertices = [](const BlockedVolumeHeader& header)
  { return static_cast<double>(header.Grid.GetNumberOfVertices()); };
  const double perSlice =
    shown / all * std::pow(vertices(whole) / vertices(pass.Volume.lock()->GetHeader()), 2.0 / 3);
  const auto slices = std::min(finished,
    std::max<std::int64_t>(whole.BlockSize,
      static_cast<std::int64_t>(std::min(all, FirstPartTriangles / std::max(1.0, perSlice)))));
  refinement.Triangles = shown + perSlice * static_cast<double>(slices);
  return slices;
}

bool VolumeRefinement::IsGrowthDue(Communicator& ranks, std::int64_t slices, Refinement& refinement)
{
  Pass& pass = this->Last;
  const Clock::time_point now = Clock::now();
  if (pass.HasGrown)
  {
    pass.HasGrown = false;
    pass.GrowthDue = now + GrowthRest * (now - pass.GrowthBegin);
  }
  refinement.Bytes =
    refinement.Triangles * EstimateBytesPerTriangle(pass.Task.Request) / pass.Task.Query.Ranks;
  std::vector<std::uint64_t> all = { now < pass.GrowthDue ? 0U : 1U, this->FindFreeMemory() };
  ranks.ReduceMinimum(all);
  refinement.FreeBytes = static_cast<double>(all[1]);
  const bool fits =
    refinement.FreeBytes <= 0 || refinement.Bytes <= UsableMemoryShare * refinement.FreeBytes;
  const bool isMore = slices > pass.Task.FinishedSlices;
  if (!fits && isMore)
  {
    pass.AreShown = nullptr; // a larger sample shows more
  }
  return isMore && all[0] != 0 && fits;
}

} // namespace isosurface
