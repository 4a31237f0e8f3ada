// SPDX-License-Identifier: BSD-3-Clause
#include "Store/ProgressiveLevels.h"

#include <algorithm>
#include <cstdint>

namespace isosurface
{
namespace
{

Result<double> EstimateTriangles(BlockedVolume& volume, std::size_t timeStep, std::size_t variable,
  const std::vector<double>& isovalues, int level)
{
  double sum = 0;
  for (const double isovalue : isovalues)
  {
    const auto triangles = volume.EstimateTriangles(timeStep, variable, isovalue, level);
    if (!triangles.IsOk())
    {
      return triangles;
    }
    sum += *triangles;
  }
  return sum;
}

Result<int> ChooseOnThisRank(BlockedVolume& volume, std::size_t timeStep, std::size_t variable,
  const std::vector<double>& isovalues, int finest)
{
  double most = 0; // triangles of the first surface
  int chosen = finest;
  for (int level = finest; level < volume.GetNumberOfLevels(); ++level)
  {
    const auto triangles = EstimateTriangles(volume, timeStep, variable, isovalues, level);
    if (!triangles.IsOk())
    {
      return triangles.GetStatus();
    }
    if (*triangles <= 0)
    {
      break;
    }
    chosen = level;
    if (level == finest)
    {
      most = FirstSurfaceShare * *triangles;
    }
    else if (*triangles <= most)
    {
      break;
    }
  }
  return chosen;
}

} // namespace

Result<int> ChooseFirstLevel(BlockedVolume& volume, std::size_t timeStep, std::size_t variable,
  const std::vector<double>& isovalues, int finest, Communicator& communicator)
{
  const auto mine = ChooseOnThisRank(volume, timeStep, variable, isovalues, finest);
  ISOSURFACE_RETURN_IF_ERROR(communicator.Agree(mine.GetStatus()));
  // All read the same files; but what ranks do together must not depend on that.
  std::vector<std::uint64_t> level = { static_cast<std::uint64_t>(*mine) };
  communicator.ReduceMaximum(level);
  return static_cast<int>(level.front());
}

int GetNextLevel(const BlockedVolume& volume, int level, int finest)
{
  return std::max(finest, volume.GetSpectrumLevel(level - 1));
}

} // namespace isosurface
