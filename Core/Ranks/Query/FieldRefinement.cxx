// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/FieldRefinement.h"

#include "Ranks/Query/SurfaceMemory.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace isosurface
{

FieldRefinement::FieldRefinement(std::function<std::uint64_t()> findFreeMemory)
  : FindFreeMemory(std::move(findFreeMemory))
{
}

void FieldRefinement::Forget()
{
  if (this->Last.Of)
  {
    this->Last.Of->Forget();
  }
  this->Last = {};
  this->Next = {};
}

void FieldRefinement::DropPrepared()
{
  if (this->Last.Of)
  {
    this->Last.Of->DropPrepared();
  }
}

//------------------------------------------------------------------------------
// A surface

Result<FieldRefinement::Choice> FieldRefinement::Begin(
  Communicator& ranks, Field& field, const RefinementRequest& wanted, const Status& asked)
{
  Pass& pass = this->Last;
  const bool isOfChange = pass.Of == &field && pass.Wanted.Change == wanted.Change;
  std::vector<std::uint64_t> sums = { isOfChange && field.IsSame() ? 0U : 1U,
    isOfChange && pass.Shown && field.IsOfLastSample() ? 1U : 0U, pass.Triangles,
    wanted.MayBeCoarse ? 0U : 1U, asked.IsOk() ? 0U : 1U };
  const std::vector<std::uint64_t> counts = field.CountForFirst();
  const auto ofField = static_cast<std::ptrdiff_t>(sums.size());
  sums.insert(sums.end(), counts.begin(), counts.end());
  ranks.ReduceSum(sums);
  if (sums[4] != 0)
  {
    return ranks.Agree(asked);
  }
  if (sums[0] != 0)
  {
    this->Forget();
    pass.Wanted = wanted;
    pass.Wanted.MayBeCoarse = sums[3] == 0;
    pass.Wanted.Level = field.FindFinestLevel(wanted.Level);
    pass.Level = pass.Wanted.Level;
    const bool mayAllStay = sums[1] == static_cast<std::uint64_t>(ranks.GetSize());
    if (wanted.IsProgressive || pass.Wanted.MayBeCoarse)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->ChooseFirst(
        ranks, field, { sums.begin() + ofField, sums.end() }, mayAllStay ? sums[2] : 0));
    }
    pass.Of = &field;
  }
  pass.IsFinal = this->IsNextFinest();
  return Choice{ pass.Level, pass.MayStay, pass.Stays, pass.IsFinal };
}

Status FieldRefinement::ChooseFirst(
  Communicator& ranks, Field& field, const std::vector<std::uint64_t>& sums, std::uint64_t shown)
{
  Pass& pass = this->Last;
  const RefinementRequest& wanted = pass.Wanted;
  Field::First first;
  const auto choose = [&]() -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(first, field.FindFirst(ranks, sums, wanted.Level));
    pass.Level = first.Level;
    // Scripts ask for the levels one by one; a window shows no more than a user can see.
    pass.IsDirect = first.IsDirect && !wanted.IsProgressive;
    pass.MayStay =
      field.BeginSample(wanted.MayBeCoarse && wanted.Level == 0 && !wanted.FindsIslands);
    return shown > 0 ? this->ChooseLevelThatStays(ranks, field, shown) : Status::Ok();
  };
  const Status chosen = Attempt("the first level cannot be chosen", choose);
  if (first.IsCommon && chosen.IsOk())
  {
    return chosen;
  }
  const auto level = static_cast<std::uint64_t>(pass.Level);
  return ranks.Agree(chosen,
    { MakeCommonFile(
      field.GetName(), 4 * level + (pass.IsDirect ? 2 : 0) + (pass.Stays ? 1 : 0)) });
}

/// Has the surface of a sample stay until there is a finer one.
Status FieldRefinement::ChooseLevelThatStays(Communicator& ranks, Field& field, std::uint64_t shown)
{
  Pass& pass = this->Last;
  for (int level = pass.Level;; level = this->GetNextLevel(field))
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const double triangles, field.EstimateTriangles(level));
    if (level == 0 || triangles > static_cast<double>(shown))
    {
      return Status::Ok(); // it follows
    }
    pass.Stays = true;
    pass.Level = level;
    pass.Triangles = static_cast<std::size_t>(triangles / ranks.GetSize());
  }
}

void FieldRefinement::SetShown(bool shown, int level, std::size_t triangles)
{
  this->Last.Shown = shown;
  this->Last.IsFinal = this->Last.IsFinal || level > this->Last.Level;
  this->Last.Stays = this->Last.Stays && shown;
  if (!this->Last.Stays)
  {
    this->Last.Triangles = triangles;
  }
}

//------------------------------------------------------------------------------
// The next surface

int FieldRefinement::GetNextLevel(const Field& field) const
{
  const Pass& pass = this->Last;
  return pass.IsDirect ? pass.Wanted.Level : field.GetNextLevel(pass.Level, pass.Wanted.Level);
}

bool FieldRefinement::IsCurrent(std::uint64_t change) const
{
  const Pass& pass = this->Last;
  return pass.Of && pass.Shown && pass.Wanted.Change == change && pass.Of->IsThere();
}

bool FieldRefinement::MayRefine(std::uint64_t change) const
{
  return this->IsCurrent(change) && !this->Last.IsFinal;
}

bool FieldRefinement::MayGrow(std::uint64_t change) const
{
  return this->IsCurrent(change) && this->Last.Level == 0 && this->Last.Of->Grows();
}

bool FieldRefinement::Refine(std::uint64_t change)
{
  Pass& pass = this->Last;
  if (this->MayGrow(change) && pass.Of->GetPrepared())
  {
    pass.Of->EndGrowth(false);
  }
  else if (this->MayRefine(change))
  {
    pass.Level = this->GetNextLevel(*pass.Of);
    pass.Stays = false;
  }
  else
  {
    return false;
  }
  pass.Shown = false;
  return true;
}

FieldRefinement::Preparation FieldRefinement::Wait(
  Communicator& ranks, double seconds, std::uint64_t change)
{
  const bool grows = this->MayGrow(change);
  const bool refines = this->MayRefine(change);
  CollectiveTask* const work = this->Last.Of ? this->Last.Of->GetPrepared() : nullptr;
  // Ranks wait by themselves for what each extracts alone.
  const bool isReady =
    work && (grows || refines) && work->WaitAlone(work->IsCollective() ? 0 : seconds);
  const double share = work ? work->GetProgress() : 0;
  std::vector<std::uint64_t> all = { grows ? 1U : 0U, refines ? 1U : 0U, work ? 1U : 0U,
    isReady ? 1U : 0U, isReady && !work->GetStatus().IsOk() ? 0U : 1U,
    static_cast<std::uint64_t>(share * Millionths) };
  ranks.ReduceMinimum(all);
  Preparation prepared{ all[0] != 0, all[1] != 0, all[2] != 0, all[3] != 0, all[4] == 0,
    static_cast<double>(all[5]) / Millionths };
  if (prepared.Exists && prepared.Refines && !prepared.IsReady && work->IsCollective())
  {
    prepared.IsReady = work->Advance(ranks, seconds);
  }
  return prepared;
}

Refinement FieldRefinement::Prepare(Communicator& ranks, double seconds, std::uint64_t change)
{
  Refinement& next = this->Next;
  Preparation prepared = this->Wait(ranks, seconds, change);
  if (prepared.Grows)
  {
    next = this->PrepareGrowth(ranks, prepared);
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

Refinement FieldRefinement::PrepareGrowth(Communicator& ranks, const Preparation& prepared)
{
  Field& field = *this->Last.Of;
  if (!prepared.Exists)
  {
    return field.Grow(ranks, this->Last.Triangles, this->FindFreeMemory());
  }
  if (prepared.HasFailed)
  {
    // What is shown stays. Indexing tells what is at fault, or a query of the index.
    field.EndGrowth(true);
    return {};
  }
  Refinement next = this->Next;
  next.Stage = prepared.IsReady ? RefinementStage::Ready : next.Stage;
  return next;
}

//------------------------------------------------------------------------------
// A finer level

Status FieldRefinement::BeginLevel(Communicator& ranks)
{
  const Pass& pass = this->Last;
  Refinement& next = this->Next;
  ISOSURFACE_ASSIGN_OR_RETURN(
    const int level, pass.Of->FitLevel(ranks, this->GetNextLevel(*pass.Of)));
  next.ShownLevel = pass.Level;
  next.NextLevel = level;
  next.FinalLevel = pass.Wanted.Level;
  bool isSizeAccepted = false;
  ISOSURFACE_RETURN_IF_ERROR(this->FindFittingLevel(ranks, isSizeAccepted));
  // The ranks wait together for a surface that each extracts, or none does.
  const bool isWanted = next.FittingLevel <= level || isSizeAccepted;
  next.Stage = isWanted ? RefinementStage::Working : RefinementStage::TooLarge;
  return isWanted ? pass.Of->Prepare(ranks, level) : Status::Ok();
}

Status FieldRefinement::FindFittingLevel(Communicator& ranks, bool& isSizeAccepted)
{
  const Pass& pass = this->Last;
  Refinement& next = this->Next;
  std::vector<double> estimates; ///< from the next level to the one that is shown
  Status status;
  for (int level = next.NextLevel; level <= pass.Level && status.IsOk(); ++level)
  {
    const auto triangles = pass.Of->EstimateTriangles(level);
    status = triangles.GetStatus();
    estimates.push_back(triangles.IsOk() ? *triangles : 0);
  }
  std::vector<std::uint64_t> limits = { this->FindFreeMemory(), pass.SizeAccepted ? 1U : 0U,
    status.IsOk() ? 1U : 0U };
  ranks.ReduceMinimum(limits);
  if (limits[2] == 0)
  {
    return ranks.Agree(status);
  }
  const auto shown = static_cast<double>(ranks.Sum(pass.Triangles));
  isSizeAccepted = limits[1] != 0;
  // A region has a part of the triangles that spectra count: that of the shown surface.
  const double part = estimates.back() > 0 ? std::min(1.0, shown / estimates.back()) : 1;
  std::vector<double> bytes;
  bytes.reserve(estimates.size());
  for (const double triangles : estimates)
  {
    bytes.push_back(pass.Of->EstimateBytes(part * triangles));
  }
  next.Triangles = part * estimates.front();
  next.Bytes = bytes.front();
  next.FreeBytes = static_cast<double>(limits[0]);
  next.FittingLevel = next.NextLevel + static_cast<int>(FindFittingSurface(bytes, next.FreeBytes));
  return Status::Ok();
}

} // namespace isosurface
