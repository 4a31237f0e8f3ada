// SPDX-License-Identifier: BSD-3-Clause
// The part of ContourExecution that goes from coarse surfaces to finer ones.
#include "ContourRefinement.h"

#include "ContourExecution.h"
#include "vtkStabbingContour.h"

#include "ErrorReport.h"
#include "Ground/Base/AvailableMemory.h"
#include "Ranks/Query/ProgressiveLevels.h"
#include "Ranks/Query/SurfaceMemory.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

constexpr double MebiByte = 1 << 20;
/// A surface that grows with an index rests so many times as long as it took to extract and to show.
constexpr int GrowthRest = 2;
/// Its first exact part has about so many at most; each later one is at most twice as deep. So the
/// first is there soon, and the index goes on.
constexpr double FirstPartTriangles = 500'000;

} // namespace

//------------------------------------------------------------------------------
Result<int> ContourExecution::ChoosePassLevel(
  const ExtractionTask& task, const std::string& sampled)
{
  const std::shared_ptr<BlockedVolume>& volume = task.Volume;
  const SurfaceQuery& query = task.Query;
  ControllerCommunicator ranks = this->GetRanks();
  Pass& pass = this->LastPass;
  const vtkMTimeType time = this->Contour.GetMTime();
  const bool isSame =
    pass.Time == time && pass.Volume.lock() == volume && pass.Query.TimeStep == query.TimeStep;
  std::vector<std::uint64_t> isNew = { isSame ? 0U : 1U };
  ranks.ReduceMaximum(isNew);
  if (isNew.front() == 0)
  {
    return pass.Level;
  }
  this->DropRefinement();
  this->OfImages.Forget();
  const Pass before = std::exchange(this->LastPass, {});
  this->LastRefinement = {};
  pass.Level = std::min(this->Contour.GetLevel(), volume->GetNumberOfLevels() - 1);
  if (this->Contour.GetProgressive() || this->CoarseAllowed)
  {
    const auto first = ChooseFirstLevel(*volume, query, pass.Level, ranks);
    ISOSURFACE_RETURN_IF_ERROR(first.GetStatus());
    // Scripts ask for the levels one by one; a window shows no more than a user can see.
    if (!this->Contour.GetProgressive() && *first > pass.Level)
    {
      const auto direct = IsDirectSurface(*volume, query, pass.Level, ranks);
      ISOSURFACE_RETURN_IF_ERROR(direct.GetStatus());
      pass.Direct = *direct;
    }
    pass.Level = *first;
  }
  pass.Time = time;
  pass.Volume = volume;
  if (this->CoarseAllowed && this->Contour.GetLevel() == 0 && !this->Contour.FindsIslands() &&
    this->Contour.GetTimeBudget() <= 0 && this->Contour.GetMaximumTriangles() == 0)
  {
    pass.Finished = task.Finished;
    // The triangles of a region are not known before it is extracted.
    pass.Sampled = query.Selection.Region.GetHalfSpaces().empty() ? sampled : "";
    ISOSURFACE_RETURN_IF_ERROR(this->KeepSurface(task, before));
  }
  return pass.Level;
}

//------------------------------------------------------------------------------
Status ContourExecution::KeepSurface(const ExtractionTask& task, const Pass& before)
{
  Pass& pass = this->LastPass;
  ControllerCommunicator ranks = this->GetRanks();
  std::vector<std::uint64_t> all = { before.Shown && before.Sampled == task.Volume->GetPath() &&
        before.Time == pass.Time && before.Query.TimeStep == task.Query.TimeStep
      ? 1U
      : 0U };
  std::vector<std::uint64_t> shown = { before.Triangles };
  ranks.ReduceMinimum(all);
  ranks.ReduceSum(shown);
  double triangles = 0; // of the level
  const auto choose = [&]() -> Status
  {
    for (int level = pass.Level; all[0] != 0; level = this->GetLevelAfterPass(*task.Volume))
    {
      const auto estimate = EstimateTriangles(*task.Volume, task.Query, level);
      ISOSURFACE_RETURN_IF_ERROR(estimate.GetStatus());
      if (level == 0 || *estimate > static_cast<double>(shown[0]))
      {
        break; // it follows
      }
      pass.Stays = true;
      pass.Level = level;
      triangles = *estimate;
    }
    return Status::Ok();
  };
  const Status status = ranks.Agree(Attempt(NotExtracted, choose));
  pass.Triangles = static_cast<std::size_t>(triangles / task.Query.Ranks);
  return status;
}

//------------------------------------------------------------------------------
void ContourExecution::SetShown(bool shown, std::size_t triangles)
{
  this->OfImages.SetShown(shown, triangles);
  this->LastPass.Shown = shown;
  this->LastPass.Stays = this->LastPass.Stays && shown;
  if (!this->LastPass.Stays)
  {
    this->LastPass.Triangles = triangles;
  }
}

//------------------------------------------------------------------------------
int ContourExecution::GetLevelAfterPass(const BlockedVolume& volume)
{
  const int finest = std::min(this->Contour.GetLevel(), volume.GetNumberOfLevels() - 1);
  return this->LastPass.Direct ? finest : GetNextLevel(volume, this->LastPass.Level, finest);
}

//------------------------------------------------------------------------------
void ContourExecution::DropRefinement()
{
  this->OfVolumes.DropPrepared();
  this->OfImages.Drop();
}

//------------------------------------------------------------------------------
// Passes

bool ContourExecution::Refine()
{
  if (this->OfImages.Refine())
  {
    return true;
  }
  Pass& pass = this->LastPass;
  const std::shared_ptr<BlockedVolume> volume = pass.Volume.lock();
  if (this->MayGrow() && this->OfVolumes.GetPrepared())
  {
    pass.FinishedSlices = this->OfVolumes.GetPrepared()->GetTask().FinishedSlices;
    pass.Shown = false;
    pass.HasGrown = true;
    return true;
  }
  if (this->Contour.GetFinal() || !pass.Shown || pass.Time != this->Contour.GetMTime() || !volume)
  {
    return false;
  }
  pass.Level = this->GetLevelAfterPass(*volume);
  pass.Shown = false;
  pass.Stays = false;
  return true;
}

//------------------------------------------------------------------------------
bool ContourExecution::MayRefine(Communicator& ranks, bool& ofImages)
{
  const Pass& pass = this->LastPass;
  const vtkMTimeType time = this->Contour.GetMTime();
  const bool may =
    !this->Contour.GetFinal() && pass.Shown && pass.Time == time && !pass.Volume.expired();
  const bool mayImages = this->OfImages.MayRefine();
  std::vector<std::uint64_t> all = { may || mayImages ? 1U : 0U, mayImages ? 1U : 0U };
  ranks.ReduceMinimum(all);
  ofImages = all[1] != 0;
  return all[0] != 0;
}

//------------------------------------------------------------------------------
Refinement ContourExecution::PrepareRefinement(double seconds)
{
  ControllerCommunicator ranks = this->GetRanks();
  std::vector<std::uint64_t> grows = { this->MayGrow() ? 1U : 0U };
  ranks.ReduceMinimum(grows);
  if (grows.front() != 0)
  {
    return this->PrepareGrowth(ranks, seconds);
  }
  bool ofImages = false;
  if (!this->MayRefine(ranks, ofImages))
  {
    this->DropRefinement();
    this->LastRefinement = {};
    return {};
  }
  if (ofImages)
  {
    this->OfImages.Prepare(ranks, seconds, this->LastRefinement);
    return this->LastRefinement;
  }
  Refinement& refinement = this->LastRefinement;
  std::vector<std::uint64_t> prepared = { this->OfVolumes.GetPrepared() ? 1U : 0U };
  ranks.ReduceMinimum(prepared);
  if (prepared.front() == 0)
  {
    if (!ranks.Agree(this->BeginRefinement(ranks, refinement)).IsOk())
    {
      // Refine extracts without preparation, and tells of the error.
      this->DropRefinement();
      refinement.Stage = RefinementStage::Ready;
    }
    if (refinement.Stage != RefinementStage::Working)
    {
      return refinement;
    }
  }
  BackgroundExtraction& extraction = *this->OfVolumes.GetPrepared();
  const bool ready = extraction.Wait(seconds);
  std::vector<std::uint64_t> slowest = { ready ? 1U : 0U,
    static_cast<std::uint64_t>(extraction.GetProgress() * Millionths) };
  ranks.ReduceMinimum(slowest);
  refinement.Stage = slowest[0] != 0 ? RefinementStage::Ready : RefinementStage::Working;
  refinement.Share = static_cast<double>(slowest[1]) / Millionths;
  return refinement;
}

//------------------------------------------------------------------------------
bool ContourExecution::MayGrow() const
{
  const Pass& pass = this->LastPass;
  return pass.Finished && !pass.GrowthEnded && pass.Level == 0 && pass.Shown &&
    pass.Time == this->Contour.GetMTime() && !pass.Volume.expired();
}

//------------------------------------------------------------------------------
Refinement ContourExecution::PrepareGrowth(Communicator& ranks, double seconds)
{
  Pass& pass = this->LastPass;
  Refinement& refinement = this->LastRefinement;
  BackgroundExtraction* const extraction = this->OfVolumes.GetPrepared();
  std::vector<std::uint64_t> prepared = { extraction ? 1U : 0U };
  ranks.ReduceMinimum(prepared);
  if (prepared.front() == 0)
  {
    refinement = this->BeginGrowth(ranks);
    return refinement;
  }
  const bool isReady = extraction->Wait(seconds);
  std::vector<std::uint64_t> all = { isReady ? 1U : 0U,
    isReady && !extraction->GetStatus().IsOk() ? 0U : 1U };
  ranks.ReduceMinimum(all);
  if (all[1] == 0)
  {
    // What is shown stays. Indexing tells what is at fault, or a query of the index.
    this->OfVolumes.DropPrepared();
    pass.GrowthEnded = true;
    pass.AreShown = nullptr;
    refinement = {};
  }
  else if (all[0] != 0)
  {
    refinement.Stage = RefinementStage::Ready;
  }
  return refinement;
}

//------------------------------------------------------------------------------
Refinement ContourExecution::BeginGrowth(Communicator& ranks)
{
  Pass& pass = this->LastPass;
  Refinement refinement;
  this->OfVolumes.DropPrepared(); // all ranks begin, or none does
  // Asked first, so that nothing is added afterwards.
  const bool hasEnded = pass.Finished->HasEnded();
  const std::int64_t mine = pass.Finished->CountSlices();
  // Each rank extracts the records that it has written, so no piece may be wanted twice or not at all.
  const bool hasPieces =
    mine == 0 || pass.Finished->GetHeader().IsInPlace() || pass.Query.Ranks == ranks.GetSize();
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
    pass.AreShown = pass.Finished->Show();
    pass.GrowthBegin = Clock::now();
    if (!ranks.Agree(this->Prepare(pass.Volume.lock(), 0, slices)).IsOk())
    {
      this->OfVolumes.DropPrepared();
      pass.GrowthDue = Clock::now() + std::chrono::seconds(1);
    }
  }
  else if (all[0] != 0 && finished == pass.FinishedSlices)
  {
    refinement.Stage = RefinementStage::None;
  }
  return refinement;
}

//------------------------------------------------------------------------------
std::int64_t ContourExecution::ChooseFinishedSlices(
  Communicator& ranks, std::int64_t finished, Refinement& refinement) const
{
  const Pass& pass = this->LastPass;
  const BlockedVolumeHeader& whole = pass.Finished->GetHeader();
  const auto all = static_cast<double>(whole.Grid.GetDimensions()[2] - 1);
  refinement.Share = static_cast<double>(pass.FinishedSlices) / all;
  std::vector<std::uint64_t> triangles = { pass.Triangles };
  ranks.ReduceSum(triangles);
  const auto shown = static_cast<double>(triangles.front());
  if (pass.FinishedSlices > 0)
  {
    const std::int64_t slices = std::min(finished, 2 * pass.FinishedSlices);
    refinement.Triangles =
      shown * static_cast<double>(slices) / static_cast<double>(pass.FinishedSlices);
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

//------------------------------------------------------------------------------
bool ContourExecution::IsGrowthDue(Communicator& ranks, std::int64_t slices, Refinement& refinement)
{
  Pass& pass = this->LastPass;
  const Clock::time_point now = Clock::now();
  if (pass.HasGrown)
  {
    pass.HasGrown = false;
    pass.GrowthDue = now + GrowthRest * (now - pass.GrowthBegin);
  }
  refinement.Bytes =
    refinement.Triangles * EstimateBytesPerTriangle(pass.Request) / pass.Query.Ranks;
  std::vector<std::uint64_t> all = { now < pass.GrowthDue ? 0U : 1U, this->FindFreeMemory() };
  ranks.ReduceMinimum(all);
  refinement.FreeBytes = static_cast<double>(all[1]);
  const bool fits =
    refinement.FreeBytes <= 0 || refinement.Bytes <= UsableMemoryShare * refinement.FreeBytes;
  if (!fits && slices > pass.FinishedSlices)
  {
    pass.AreShown = nullptr; // a larger sample shows more
  }
  return slices > pass.FinishedSlices && all[0] != 0 && fits;
}

//------------------------------------------------------------------------------
Status ContourExecution::BeginRefinement(Communicator& ranks, Refinement& refinement)
{
  const Pass& pass = this->LastPass;
  const std::shared_ptr<BlockedVolume> volume = pass.Volume.lock();
  const int finest = std::min(this->Contour.GetLevel(), volume->GetNumberOfLevels() - 1);
  LevelChoice choice;
  choice.Level = this->GetLevelAfterPass(*volume);
  const ExtractionBudget budget = { this->Contour.GetTimeBudget(),
    static_cast<std::uint64_t>(this->Contour.GetMaximumTriangles()) };
  if (budget.IsLimited())
  {
    QueryStatistics statistics;
    const auto within = ChooseLevel(
      *volume, pass.Query, choice.Level, budget, this->OfVolumes.GetRate(), ranks, statistics);
    ISOSURFACE_RETURN_IF_ERROR(within.GetStatus());
    choice = *within;
  }
  refinement.ShownLevel = pass.Level;
  refinement.NextLevel = choice.Level;
  refinement.FinalLevel = finest;
  ISOSURFACE_RETURN_IF_ERROR(this->FindFittingLevel(ranks, *volume, refinement));
  // The ranks wait together for a surface that each extracts, or none does.
  std::vector<std::uint64_t> limits = { static_cast<std::uint64_t>(refinement.FittingLevel),
    pass.SizeAccepted ? 0U : 1U };
  ranks.ReduceMaximum(limits);
  refinement.FittingLevel = static_cast<int>(limits[0]);
  const bool isWanted = refinement.FittingLevel <= choice.Level || limits[1] == 0;
  refinement.Stage = isWanted ? RefinementStage::Working : RefinementStage::TooLarge;
  return isWanted ? this->Prepare(volume, choice.Level, 0) : Status::Ok();
}

//------------------------------------------------------------------------------
Status ContourExecution::Prepare(
  const std::shared_ptr<BlockedVolume>& volume, int level, std::int64_t finishedSlices)
{
  const Pass& pass = this->LastPass;
  const int threads = this->ChooseThreads();
  return Attempt("the next surface cannot be prepared",
    [&]
    {
      ExtractionTask task = { volume, pass.Query, pass.Request, threads, {} };
      task.Finished = pass.Finished;
      task.FinishedSlices = finishedSlices;
      this->OfVolumes.Prepare(std::move(task), level);
      return Status::Ok();
    });
}

//------------------------------------------------------------------------------
std::uint64_t ContourExecution::FindFreeMemory()
{
  const double limit = this->Contour.GetRefinementMemory() * MebiByte;
  return limit > 0
    ? static_cast<std::uint64_t>(limit)
    : GetAvailableMemory() / static_cast<std::uint64_t>(std::max(1, this->RanksOnNode));
}

//------------------------------------------------------------------------------
Status ContourExecution::FindFittingLevel(
  Communicator& ranks, BlockedVolume& volume, Refinement& refinement)
{
  const Pass& pass = this->LastPass;
  std::vector<std::uint64_t> free = { this->FindFreeMemory() };
  std::vector<std::uint64_t> shown = { pass.Triangles };
  ranks.ReduceMinimum(free);
  ranks.ReduceSum(shown);
  std::vector<double> estimates; ///< from the next level to the one that is shown
  Status status;
  for (int level = refinement.NextLevel; level <= pass.Level && status.IsOk(); ++level)
  {
    const auto triangles = EstimateTriangles(volume, pass.Query, level);
    status = triangles.GetStatus();
    estimates.push_back(triangles.IsOk() ? *triangles : 0);
  }
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(status));
  // A region has a part of the triangles that spectra count: that of the shown surface.
  const double part =
    estimates.back() > 0 ? std::min(1.0, static_cast<double>(shown.front()) / estimates.back()) : 1;
  for (double& estimate : estimates)
  {
    estimate *= part;
  }
  const double bytesPerTriangle = EstimateBytesPerTriangle(pass.Request) / pass.Query.Ranks;
  std::vector<double> bytes;
  bytes.reserve(estimates.size());
  for (const double triangles : estimates)
  {
    bytes.push_back(bytesPerTriangle * triangles);
  }
  refinement.Triangles = estimates.front();
  refinement.Bytes = bytes.front();
  refinement.FreeBytes = static_cast<double>(free.front());
  refinement.FittingLevel =
    refinement.NextLevel + static_cast<int>(FindFittingSurface(bytes, refinement.FreeBytes));
  return Status::Ok();
}

} // namespace isosurface
