// SPDX-License-Identifier: BSD-3-Clause
#include "ImageRefinement.h"

#include "ErrorReport.h"

#include "vtkAlgorithm.h"

#include "Ground/Base/Fingerprint.h"
#include "Ranks/Query/ProgressiveLevels.h"

#include <cmath>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/// No coarse surface of images has more, so that it takes a few hundredths of a second on two cores.
constexpr std::uint64_t CoarseVertices = 1 << 20;
/// Surfaces of so few have at most FirstSurfaceTriangles, about, even in noise.
constexpr std::uint64_t ProbedVertices = 1 << 15;
/// To look at each of so many takes a hundredth of a second.
constexpr std::uint64_t DirectVertices = 1 << 23;

} // namespace

//------------------------------------------------------------------------------
ImageRefinement::ImageRefinement(vtkAlgorithm& filter)
  : Filter(filter)
{
}

//------------------------------------------------------------------------------
Status ImageRefinement::Extract(
  Communicator& ranks, ImageContour::Query query, bool mayBeCoarse, ContourOutcome& outcome)
{
  const std::uint64_t vertices = this->Begin(ranks, std::move(query), mayBeCoarse);
  const Status status = vertices > 0 ? this->ExtractFirst(ranks, vertices, outcome)
    : this->Last.Level > 0           ? this->ExtractCoarsely(ranks, outcome)
                                     : this->ExtractExactly(ranks, outcome);
  outcome.Final = this->Last.Level == 0;
  outcome.Cost.Level = this->Last.Level;
  return status;
}

//------------------------------------------------------------------------------
std::uint64_t ImageRefinement::Begin(
  Communicator& ranks, ImageContour::Query query, bool mayBeCoarse)
{
  Pass& pass = this->Last;
  Fingerprint input;
  std::vector<std::uint64_t> sums = { 0, query.Pieces.Pieces.size() };
  bool isHidden = false;
  for (const ImagePiece& piece : query.Pieces.Pieces)
  {
    const VertexBox& box = piece.Samples.Components.front().Box;
    input.AddNumber(reinterpret_cast<std::uintptr_t>(piece.Samples.Array.Get()));
    input.AddNumber(piece.GetTime());
    input.AddNumber(static_cast<std::uint64_t>(box.GetNumberOfVertices()));
    sums[0] += static_cast<std::uint64_t>(box.GetNumberOfVertices());
    isHidden = isHidden || !piece.Samples.Hidden.IsEmpty();
  }
  const vtkMTimeType time = this->Filter.GetMTime();
  const bool isNew = pass.Time != time || pass.Input != input.Get();
  std::vector<std::uint64_t> decisive = { isNew ? 1U : 0U, mayBeCoarse && !isHidden ? 0U : 1U };
  ranks.ReduceMaximum(decisive);
  ranks.ReduceSum(sums);
  if (decisive[0] != 0)
  {
    this->Drop();
    pass = {};
  }
  pass.Time = time;
  pass.Input = input.Get();
  pass.HasPieces = sums[1] > 1;
  pass.Exact = std::move(query);
  return decisive[0] != 0 && decisive[1] == 0 ? sums[0] : 0;
}

//------------------------------------------------------------------------------
Status ImageRefinement::ExtractFirst(
  Communicator& ranks, std::uint64_t vertices, ContourOutcome& outcome)
{
  constexpr double growth = 4; // of triangles from a level to the next finer one
  const auto countVertices = [vertices](int level) { return vertices >> (3 * level); };
  int& level = this->Last.Level;
  while (countVertices(level) > ProbedVertices)
  {
    ++level;
  }
  for (; level > 0; --level)
  {
    ContourOutcome coarse;
    coarse.ArrayName = outcome.ArrayName;
    ISOSURFACE_RETURN_IF_ERROR(this->ExtractCoarsely(ranks, coarse));
    const auto count = static_cast<double>(ranks.Sum(coarse.Extracted.NumberOfTriangles));
    if (vertices <= DirectVertices && count * std::pow(growth, level) <= FirstSurfaceTriangles)
    {
      level = 0;
      break;
    }
    if (countVertices(level - 1) > CoarseVertices || growth * count > FirstSurfaceTriangles)
    {
      outcome = std::move(coarse);
      return Status::Ok();
    }
  }
  return this->ExtractExactly(ranks, outcome);
}

//------------------------------------------------------------------------------
ImageContour::Query ImageRefinement::MakeQuery() const
{
  const Pass& pass = this->Last;
  // Blocks with nothing but samples inside have a surface, too, if sides are closed.
  const bool joins = pass.HasPieces && pass.Exact.Request.ClosedSides.IsEmpty();
  return pass.Level > 0 ? pass.Exact.Coarsen(pass.Level, joins) : pass.Exact;
}

//------------------------------------------------------------------------------
IslandGrids ImageRefinement::MakeIslandGrids(Communicator& ranks) const
{
  return this->MakeQuery().MakeIslandGrids(ranks);
}

//------------------------------------------------------------------------------
Status ImageRefinement::ExtractCoarsely(Communicator& ranks, ContourOutcome& outcome)
{
  ImageContour::Query query;
  const auto make = [&]
  {
    query = this->MakeQuery();
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotExtracted, make));
  return ranks.Agree(this->Coarse.Extract(ranks, query, MakeProgress(this->Filter), outcome));
}

//------------------------------------------------------------------------------
Status ImageRefinement::ExtractExactly(Communicator& ranks, ContourOutcome& outcome)
{
  const bool prepared = ranks.All(this->Prepared != nullptr);
  const Progress progress = MakeProgress(this->Filter);
  if (!prepared)
  {
    this->Prepared.reset();
    return this->Exact.Extract(ranks, this->Last.Exact, progress, outcome);
  }
  const std::unique_ptr<ExactSurface> refinement = std::move(this->Prepared);
  ISOSURFACE_RETURN_IF_ERROR(refinement->Work->Finish(ranks, progress));
  refinement->Outcome.ArrayName = outcome.ArrayName;
  outcome = std::move(refinement->Outcome);
  return Status::Ok();
}

//------------------------------------------------------------------------------
void ImageRefinement::End()
{
  if (this->Last.Level == 0)
  {
    this->Last.Exact = {};
  }
}

//------------------------------------------------------------------------------
void ImageRefinement::SetShown(bool shown, std::size_t triangles)
{
  this->Last.Shown = shown;
  this->Last.Triangles = triangles;
}

//------------------------------------------------------------------------------
bool ImageRefinement::MayRefine() const
{
  return this->Last.Level > 0 && this->Last.Shown && this->Last.Time == this->Filter.GetMTime();
}

//------------------------------------------------------------------------------
bool ImageRefinement::Refine()
{
  if (!this->MayRefine())
  {
    return false;
  }
  this->Last.Level = 0;
  this->Last.Shown = false;
  return true;
}

//------------------------------------------------------------------------------
Refinement ImageRefinement::Prepare(Communicator& ranks, double seconds)
{
  const Pass& pass = this->Last;
  Refinement& next = this->Next;
  std::vector<std::uint64_t> all = { this->MayRefine() ? 1U : 0U, this->Prepared ? 1U : 0U };
  ranks.ReduceMinimum(all);
  if (all[0] == 0)
  {
    this->Drop();
    next = {};
    return next;
  }
  if (all[1] == 0)
  {
    this->Drop();
    next = {};
    next.ShownLevel = pass.Level;
    const std::uint64_t triangles = ranks.Sum(pass.Triangles);
    next.Triangles = static_cast<double>(triangles << (2 * pass.Level));
    if (!this->BeginExact(ranks).IsOk())
    {
      // Refine extracts without preparation, and tells of the error.
      this->Drop();
      next.Stage = RefinementStage::Ready;
      return next;
    }
  }
  const bool isReady = this->Prepared->Work->Advance(ranks, seconds);
  const std::uint64_t slowest =
    ranks.Minimum(static_cast<std::uint64_t>(this->Prepared->Work->GetProgress() * Millionths));
  next.Stage = isReady ? RefinementStage::Ready : RefinementStage::Working;
  next.Share = static_cast<double>(slowest) / Millionths;
  return next;
}

//------------------------------------------------------------------------------
Status ImageRefinement::BeginExact(Communicator& ranks)
{
  this->Prepared = std::make_unique<ExactSurface>();
  ExactSurface& prepared = *this->Prepared;
  return ranks.Agree(Attempt("the next surface cannot be prepared",
    [&]
    {
      prepared.Work = std::make_unique<CollectiveTask>(ranks, NotExtracted,
        [this, &prepared, query = this->Last.Exact](Communicator& all, const Progress& advance)
        { return this->Exact.Extract(all, query, advance, prepared.Outcome); });
      return Status::Ok();
    }));
}

//------------------------------------------------------------------------------
void ImageRefinement::DropUnfinished()
{
  if (this->Prepared && !this->Prepared->Work->HasEnded())
  {
    this->Prepared.reset();
  }
}

} // namespace isosurface
