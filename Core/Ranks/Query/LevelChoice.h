// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LevelChoice_h
#define isosurface_LevelChoice_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ranks/Query/ExtractionRate.h"
#include "Ranks/Sharing/QueryPlan.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/QueryStatistics.h"

#include <cstdint>

namespace isosurface
{

/// What an isosurface may cost; equal on all ranks. Without either number, every level fits.
struct ExtractionBudget
{
  double Seconds = 0;          ///< 0: no limit
  std::uint64_t Triangles = 0; ///< of all ranks and isovalues together; 0: no limit

  bool IsLimited() const { return this->Seconds > 0 || this->Triangles > 0; }
};

/// The sum of BlockedVolume::EstimateTriangles over the isovalues, in the whole volume.
Result<double> EstimateTriangles(BlockedVolume& volume, const SurfaceQuery& query, int level);

/// What limited the choice of a level.
enum class LevelLimit
{
  None,
  Triangles,
  Seconds
};

/// A chosen level. Equal on all ranks except for the work.
struct LevelChoice
{
  int Level = 0;
  LevelLimit Limit = LevelLimit::None; ///< why no finer level was chosen
  double Triangles = 0;                ///< estimated, of all ranks
  double Seconds = 0;                  ///< predicted, of the slowest rank
  ExtractionWork Work;                 ///< this rank's
};

/**
 * Chooses the finest level, not finer than `finest`, whose surface fits the budget; the coarsest
 * level if none does. Triangles are those of BlockedVolume::EstimateTriangles, in proportion to the
 * selected active blocks. `rate` predicts the seconds from the active blocks of each rank's share,
 * from those that are not in the block cache, and from an equal share of the triangles.
 * Collective: each rank has its own rate; the slowest rank decides.
 *
 * Errors: of PlanQuery and EstimateTriangles, on all ranks. Cost: PlanQuery for the
 * volume and the overviews that have a possible level, from the coarsest on, until one exceeds the
 * budget.
 */
Result<LevelChoice> ChooseLevel(BlockedVolume& volume, const SurfaceQuery& query, int finest,
  const ExtractionBudget& budget, const ExtractionRate& rate, Communicator& ranks,
  QueryStatistics& statistics);

} // namespace isosurface

#endif
