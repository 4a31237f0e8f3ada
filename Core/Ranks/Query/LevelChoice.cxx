// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/LevelChoice.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace isosurface
{
namespace
{

/// The active blocks of the volume itself or of one overview, and how many of them are selected.
struct ActiveBlocks
{
  std::uint32_t Overview;
  std::vector<BlockReference> Blocks;
  double SelectedShare = 1;
};

Result<ActiveBlocks> FindActiveBlocks(
  BlockedVolume& volume, const SurfaceQuery& query, int level, QueryStatistics& statistics)
{
  ActiveBlocks active;
  active.Overview = volume.FindLevel(level).Overview;
  ISOSURFACE_ASSIGN_OR_RETURN(auto plan, PlanQuery(volume, query, level, statistics));
  active.Blocks = std::move(plan.Blocks);
  if (!query.Selection.IsPlain())
  {
    SurfaceQuery whole = query;
    whole.Selection = {};
    ISOSURFACE_ASSIGN_OR_RETURN(const auto all, PlanQuery(volume, whole, level, statistics));
    active.SelectedShare = static_cast<double>(active.Blocks.size()) /
      static_cast<double>(std::max<std::size_t>(1, all.Blocks.size()));
  }
  return active;
}

ExtractionWork EstimateWork(const BlockedVolume& volume, const SurfaceQuery& query, int level,
  const ActiveBlocks& active, double triangles)
{
  std::vector<std::size_t> variables = { query.Variable };
  for (const std::size_t array : query.Attributes)
  {
    for (int component = 0; component < volume.GetVariables().GetComponents(array); ++component)
    {
      variables.push_back(*volume.GetVariables().Find(array, component));
    }
  }
  const auto all = static_cast<double>(volume.FindLevel(level).Grid->GetNumberOfBlocks());
  ExtractionWork work;
  work.Blocks = static_cast<double>(active.Blocks.size());
  work.Triangles = triangles;
  for (const std::size_t variable : variables)
  {
    const double bytes = static_cast<double>(volume.EstimateBytes(variable, level)) / all;
    work.SampleBytes += work.Blocks * bytes;
    const auto missing =
      static_cast<double>(std::count_if(active.Blocks.begin(), active.Blocks.end(),
        [&](const BlockReference& block)
        { return !volume.IsCached(block, query.TimeStep, variable, level); }));
    work.BlocksRead += missing;
    work.ReadBytes += missing * bytes;
  }
  return work;
}

} // namespace

Result<double> EstimateTriangles(BlockedVolume& volume, const SurfaceQuery& query, int level)
{
  double triangles = 0;
  for (const double isovalue : query.Isovalues)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto estimate, volume.EstimateTriangles(query.TimeStep, query.Variable, isovalue, level));
    triangles += estimate;
  }
  return triangles;
}

Result<LevelChoice> ChooseLevel(BlockedVolume& volume, const SurfaceQuery& query, int finest,
  const ExtractionBudget& budget, const ExtractionRate& rate, Communicator& ranks,
  QueryStatistics& statistics)
{
  constexpr double Nanoseconds = 1e9;
  const int coarsest = volume.GetNumberOfLevels() - 1;
  std::optional<ActiveBlocks> active;
  LevelChoice choice;
  for (int level = coarsest; level >= std::min(finest, coarsest); --level)
  {
    Status status;
    LevelChoice finer;
    finer.Level = level;
    if (!active || active->Overview != volume.FindLevel(level).Overview)
    {
      auto found = FindActiveBlocks(volume, query, level, statistics);
      status = found.GetStatus();
      active = found.IsOk() ? std::move(*found) : ActiveBlocks();
    }
    if (status.IsOk())
    {
      const auto triangles = EstimateTriangles(volume, query, level);
      status = triangles.GetStatus();
      finer.Triangles = triangles.IsOk() ? *triangles * active->SelectedShare : 0;
      finer.Work = EstimateWork(volume, query, level, *active, finer.Triangles / query.Ranks);
    }
    // The ranks' shares of selected blocks differ.
    std::vector<std::uint64_t> greatest = {
      static_cast<std::uint64_t>(std::min(rate.Predict(finer.Work), 1e9) * Nanoseconds),
      static_cast<std::uint64_t>(std::llround(finer.Triangles))
    };
    ISOSURFACE_RETURN_IF_ERROR(ranks.ReduceAgreed(status, greatest));
    finer.Seconds = static_cast<double>(greatest[0]) / Nanoseconds;
    finer.Triangles = static_cast<double>(greatest[1]);

    const bool isTooLarge =
      budget.Triangles > 0 && finer.Triangles > static_cast<double>(budget.Triangles);
    const bool isTooSlow = budget.Seconds > 0 && finer.Seconds > budget.Seconds;
    const LevelLimit limit = isTooLarge ? LevelLimit::Triangles
      : isTooSlow                       ? LevelLimit::Seconds
                                        : LevelLimit::None;
    if (limit == LevelLimit::None || level == coarsest)
    {
      choice = finer;
    }
    if (limit != LevelLimit::None)
    {
      choice.Limit = limit;
      break;
    }
  }
  return choice;
}

} // namespace isosurface
