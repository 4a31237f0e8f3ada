// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/MemoryField.h"

#include "Ground/Base/Coding.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
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

constexpr const char* NotExtracted = "the isosurface cannot be extracted";

/// Of all ranks; or the error of any.
Result<double> SumTriangles(Communicator& ranks, const Status& extracted, const Surface& mine)
{
  const auto tell = [&](Message& message) -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(extracted);
    AppendVarint(message, mine.NumberOfTriangles);
    return Status::Ok();
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto all, GatherFromAll(ranks, NotExtracted, tell));
  double triangles = 0;
  for (const Message& message : all)
  {
    triangles += static_cast<double>(ByteReader(message).ReadVarint());
  }
  return triangles;
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

bool MemoryField::Joins() const
{
  // Blocks with nothing but samples inside have a surface, too, if sides are closed.
  return this->AreSeveral && this->Asked.Request.ClosedSides.IsEmpty();
}

MemoryQuery MemoryField::MakeQuery(int level) const
{
  return level > 0 ? this->Asked.Coarsen(level, this->Joins()) : this->Asked;
}

Status MemoryField::MakeQueries(
  const std::vector<int>& levels, std::vector<MemoryQuery>& queries) const
{
  const auto make = [&]
  {
    for (const int level : levels)
    {
      queries.push_back(this->MakeQuery(level));
    }
    return Status::Ok();
  };
  return Attempt(NotExtracted, make);
}

std::vector<std::uint64_t> MemoryField::CountForFirst() const
{
  const MemoryGrids& samples = this->Asked.Samples;
  const auto hides = [](const MemoryPiece& piece) { return !piece.Hidden.IsEmpty(); };
  return { samples.CountSamples(), samples.Pieces.size(),
    static_cast<std::uint64_t>(
      std::count_if(samples.Pieces.begin(), samples.Pieces.end(), hides)) };
}

/// The finest surface that two cores extract and draw within some 0.1 s, if the exact one takes longer.
Result<Field::First> MemoryField::FindFirst(
  Communicator& ranks, const std::vector<std::uint64_t>& sums, int finest)
{
  const First direct{ finest, false, true };
  this->AreSeveral = sums[1] > 1;
  const auto countVertices = [&](int level) { return sums[0] >> (3 * level); };
  int coarsest = 0;
  while (countVertices(coarsest) > ProbedVertices)
  {
    ++coarsest;
  }
  std::vector<int> levels;
  for (int level = coarsest; level > 0 && sums[2] == 0; --level)
  {
    if (level == coarsest || countVertices(level) <= CoarseVertices)
    {
      levels.push_back(level);
    }
  }
  if (levels.empty())
  {
    return direct;
  }
  std::vector<MemoryQuery> queries;
  const Status made = this->MakeQueries(levels, queries);
  std::vector<JoinedGrids> joined;
  if (this->Joins())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(joined, JoinedGrids::Make(ranks, made, std::move(queries)));
  }
  queries.resize(levels.size());
  for (std::size_t n = 0; n < levels.size(); ++n)
  {
    const int level = levels[n];
    ExtractionOutcome coarse;
    coarse.Cost.Level = level;
    const Status extracted = this->Joins()
      ? this->Coarse.Extract(ranks, joined[n], this->Advance, coarse)
      : this->Coarse.Extract(ranks, made, queries[n], this->Advance, coarse);
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto triangles, SumTriangles(ranks, extracted, coarse.Extracted));
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
      return First{ level, true, true };
    }
  }
  return direct;
}

Result<double> MemoryField::EstimateTriangles(int level)
{
  return this->ProbedTriangles * std::pow(TriangleGrowth, this->ProbedLevel - level);
}

Status MemoryField::Extract(Communicator& ranks, int level, ExtractionOutcome& outcome)
{
  if (level > 0)
  {
    if (!this->Probed)
    {
      std::vector<MemoryQuery> query;
      const Status made = this->MakeQueries({ level }, query);
      query.resize(1);
      query.front().Joins = this->Joins(); // on all ranks
      outcome.Cost.Level = level;
      return this->Coarse.Extract(ranks, made, query.front(), this->Advance, outcome);
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
    return this->Exact.Extract(ranks, Status::Ok(), this->Asked, this->Advance, outcome);
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
        { return this->Exact.Extract(all, Status::Ok(), query, advance, outcome); });
      return Status::Ok();
    });
}

} // namespace isosurface
