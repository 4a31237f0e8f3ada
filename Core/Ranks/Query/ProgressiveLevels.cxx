// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/ProgressiveLevels.h"

#include <algorithm>

namespace isosurface
{

Result<int> FindFirstLevel(BlockedVolume& volume, const SurfaceQuery& query, int finest)
{
  double most = 0; // triangles of the first surface
  int chosen = finest;
  for (int level = finest; level < volume.GetNumberOfLevels(); ++level)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto triangles, EstimateTriangles(volume, query, level));
    if (triangles <= 0)
    {
      break;
    }
    chosen = level;
    if (level == finest)
    {
      most = std::min(FirstSurfaceTriangles, FirstSurfaceShare * triangles);
    }
    else if (triangles <= most)
    {
      break;
    }
  }
  return chosen;
}

Result<bool> IsDirectSurface(BlockedVolume& volume, const SurfaceQuery& query, int finest)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto triangles, EstimateTriangles(volume, query, finest));
  return triangles <=
    (volume.GetHeader().IsInPlace() ? DirectSurfaceTrianglesInPlace : DirectSurfaceTriangles);
}

int GetNextLevel(const BlockedVolume& volume, int level, int finest)
{
  return std::max(finest, volume.GetSpectrumLevel(level - 1));
}

} // namespace isosurface
