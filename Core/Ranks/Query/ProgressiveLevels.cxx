// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/ProgressiveLevels.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace isosurface
{
namespace
{

Result<int> ChooseOnThisRank(BlockedVolume& volume, const SurfaceQuery& query, int finest)
{
  double most = 0; // triangles of the first surface
  int chosen = finest;
  for (int level = finest; level < volume.GetNumberOfLevels(); ++level)
  {
    const auto triangles = EstimateTriangles(volume, query, level);
    ISOSURFACE_RETURN_IF_ERROR(triangles.GetStatus());
    if (*triangles <= 0)
    {
      break;
    }
    chosen = level;
    if (level == finest)
    {
      most = std::min(FirstSurfaceTriangles, FirstSurfaceShare * *triangles);
    }
    else if (*triangles <= most)
    {
      break;
    }
  }
  return chosen;
}

} // namespace

Result<int> ChooseFirstLevel(
  BlockedVolume& volume, const SurfaceQuery& query, int finest, Communicator& ranks)
{
  const auto mine = ChooseOnThisRank(volume, query, finest);
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(mine.GetStatus()));
  // All ranks read the same files, but collective operations must not depend on that.
  std::vector<std::uint64_t> level = { static_cast<std::uint64_t>(*mine) };
  ranks.ReduceMaximum(level);
  return static_cast<int>(level.front());
}

Result<bool> IsDirectSurface(
  BlockedVolume& volume, const SurfaceQuery& query, int finest, Communicator& ranks)
{
  const auto triangles = EstimateTriangles(volume, query, finest);
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(triangles.GetStatus()));
  const double most =
    volume.GetHeader().IsInPlace() ? DirectSurfaceTrianglesInPlace : DirectSurfaceTriangles;
  std::vector<std::uint64_t> direct = { *triangles <= most ? 1U : 0U };
  ranks.ReduceMinimum(direct);
  return direct.front() != 0;
}

int GetNextLevel(const BlockedVolume& volume, int level, int finest)
{
  return std::max(finest, volume.GetSpectrumLevel(level - 1));
}

} // namespace isosurface
