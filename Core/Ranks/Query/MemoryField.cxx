// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/MemoryField.h"

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
/// Of triangles, from a level to the next finer one.
constexpr double TriangleGrowth = 4;

/// The surfaces of all grids, on all ranks, have points of one type, at all levels.
PointPrecision ChoosePrecision(const MemoryGrids& samples, PointPrecision wanted)
{
  for (std::size_t grid = 0; grid < samples.Grids.size(); ++grid)
  {
    const auto& lines = samples.Lines[grid];
    if (wanted == PointPrecision::Default &&
      NeedsDoublePoints(samples.Grids[grid], lines ? &*lines : nullptr))
    {
      return PointPrecision::Double;
    }
  }
  return wanted == PointPrecision::Default ? PointPrecision::Single : wanted;
}

} // namespace

void MemoryField::Ask(MemoryQuery query, Progress advance)
{
  const std::uint64_t identity = query.Samples.ComputeFingerprint();
  this->Same = std::exchange(this->Identity, identity) == identity;
  query.Request.Precision = ChoosePrecision(query.Samples, query.Request.Precision);
  this->Asked = std::move(query);
  this->Advance = std::move(advance);
}

void MemoryField::Forget()
{
  this->DropPrepared();
  this->HasBegun = false;
  this->Probed.reset();
}

void MemoryField::DropUnfinished()
{
  if (this->Prepared && !this->Prepared->GetWork().HasEnded())
  {
    this->Prepared.reset();
  }
}

MemoryQuery MemoryField::MakeQuery(int level) const
{
  // Blocks with nothing but samples inside have a surface, too, if sides are closed.
  const bool joins = this->AreSeveral && this->Asked.Request.ClosedSides.IsEmpty();
  return level > 0 ? this->Asked.Coarsen(level, joins) : this->Asked;
}

/// The finest surface that two cores extract and draw within some 0.1 s, if the exact one takes longer.
Result<Field::First> MemoryField::FindFirst(Communicator& ranks, int finest)
{
  const MemoryGrids& samples = this->Asked.Samples;
  std::vector<std::uint64_t> sums = { samples.CountSamples(), samples.Pieces.size(), 0 };
  for (const MemoryPiece& piece : samples.Pieces)
  {
    sums[2] += piece.Hidden.IsEmpty() ? 0U : 1U;
  }
  ranks.ReduceSum(sums);
  this->AreSeveral = sums[1] > 1;
  if (sums[2] > 0)
  {
    return First{ finest };
  }
  const auto countVertices = [&](int level) { return sums[0] >> (3 * level); };
  int level = 0;
  while (countVertices(level) > ProbedVertices)
  {
    ++level;
  }
  for (; level > 0; --level)
  {
    ExtractionOutcome coarse;
    ISOSURFACE_RETURN_IF_ERROR(this->ExtractCoarsely(ranks, level, coarse));
    const auto triangles = static_cast<double>(ranks.Sum(coarse.Extracted.NumberOfTriangles));
    if (sums[0] <= DirectVertices &&
      triangles * std::pow(TriangleGrowth, level) <= FirstSurfaceTriangles)
    {
      break;
    }
    if (countVertices(level - 1) > CoarseVertices ||
      TriangleGrowth * triangles > FirstSurfaceTriangles)
    {
      this->Probed = std::move(coarse);
      this->ProbedLevel = level;
      this->ProbedTriangles = triangles;
      return First{ level, true };
    }
  }
  return First{ finest };
}

Result<double> MemoryField::EstimateTriangles(int level)
{
  return this->ProbedTriangles * std::pow(TriangleGrowth, this->ProbedLevel - level);
}

Status MemoryField::ExtractCoarsely(Communicator& ranks, int level, ExtractionOutcome& outcome)
{
  MemoryQuery query;
  const auto make = [&]
  {
    query = this->MakeQuery(level);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, "the isosurface cannot be extracted", make));
  outcome.Cost.Level = level;
  return ranks.Agree(this->Coarse.Extract(ranks, query, this->Advance, outcome));
}

Status MemoryField::Extract(Communicator& ranks, int level, ExtractionOutcome& outcome)
{
  if (level > 0)
  {
    if (!this->Probed)
    {
      return this->ExtractCoarsely(ranks, level, outcome);
    }
    outcome = std::move(*this->Probed);
    this->Probed.reset();
    return Status::Ok();
  }
  outcome.Cost.Level = 0;
  // Each rank may have dropped it, but all began it.
  if (!this->HasBegun || !ranks.All(this->Prepared != nullptr))
  {
    this->Prepared.reset();
    return this->Exact.Extract(ranks, this->Asked, this->Advance, outcome);
  }
  const std::unique_ptr<BackgroundExtraction> prepared = std::move(this->Prepared);
  return prepared->Take(ranks, this->Advance, outcome);
}

Status MemoryField::Prepare(Communicator& ranks, int)
{
  this->Prepared.reset(); // it uses Exact
  this->HasBegun = true;
  return Attempt("the next surface cannot be prepared",
    [&]
    {
      this->Prepared = std::make_unique<BackgroundExtraction>(ranks,
        [this, query = this->Asked](
          Communicator& all, const Progress& advance, ExtractionOutcome& outcome)
        { return this->Exact.Extract(all, query, advance, outcome); });
      return Status::Ok();
    });
}

} // namespace isosurface
