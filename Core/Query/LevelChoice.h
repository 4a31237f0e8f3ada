// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LevelChoice_h
#define isosurface_LevelChoice_h

#include "Base/Communicator.h"
#include "Base/Status.h"
#include "Query/ExtractionRate.h"
#include "Store/BlockedVolume.h"
#include "Store/QueryStatistics.h"
#include "Volume/BlockSelection.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// What an isosurface may cost. Equal on all ranks.
struct ExtractionBudget
{
  double Seconds = 0;          ///< 0: as many as it takes
  std::uint64_t Triangles = 0; ///< of all ranks and isovalues together; 0: as many as there are

  bool IsLimited() const { return this->Seconds > 0 || this->Triangles > 0; }
};

/// An isosurface of a blocked volume; equal on all ranks where nothing else is said.
struct SurfaceQuery
{
  std::size_t TimeStep = 0;
  std::size_t Variable = 0;
  std::vector<std::size_t> Attributes; ///< arrays to interpolate
  std::vector<double> Isovalues;
  BlockSelection Selection;
  /// The share that this rank extracts; not equal on all ranks.
  int Rank = 0;
  int Ranks = 1;
};

/// The sum of BlockedVolume::EstimateTriangles over the isovalues, wherever they are.
Result<double> EstimateTriangles(BlockedVolume& volume, const SurfaceQuery& query, int level);

/// What limited a choice.
enum class LevelLimit
{
  None,
  Triangles,
  Seconds
};

/// Equal on all ranks but for the work.
struct LevelChoice
{
  int Level = 0;
  LevelLimit Limit = LevelLimit::None; ///< what forbids the next finer level, or the finest wanted
  double Triangles = 0;                ///< estimated, of all ranks
  double Seconds = 0;                  ///< predicted, of the slowest rank
  ExtractionWork Work;                 ///< this rank's
};

/**
 * The finest level, not finer than `finest`, whose surface fits the budget; the coarsest, if none
 * does. Triangles are those of BlockedVolume::EstimateTriangles, in proportion to the selected
 * ones of the active blocks; seconds are predicted by `rate` from the active blocks of each rank's
 * share, from what of them is not in the block cache, and from an equal share of the triangles.
 * Collective: the ranks have rates of their own, the slowest decides.
 *
 * Errors: of FindActiveBlocks and EstimateTriangles, on all ranks. Cost: FindActiveBlocks for each
 * of the volume and its overviews that has a level in question, from the coarsest on, until one is
 * beyond the budget.
 */
Result<LevelChoice> ChooseLevel(BlockedVolume& volume, const SurfaceQuery& query, int finest,
  const ExtractionBudget& budget, const ExtractionRate& rate, Communicator& ranks,
  QueryStatistics& statistics);

} // namespace isosurface

#endif
