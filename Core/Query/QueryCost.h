// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_QueryCost_h
#define isosurface_QueryCost_h

#include "Query/LevelChoice.h"
#include "Store/QueryStatistics.h"

#include <cstdint>
#include <optional>

namespace isosurface
{

/// What a query cost one rank.
struct QueryCost
{
  QueryStatistics Reading;
  std::uint64_t Triangles = 0;
  int Level = 0;                     ///< that the surface was extracted from
  std::optional<LevelChoice> Choice; ///< of the level, within a budget
  double ExtractSeconds = 0; ///< wall clock of extraction, the reading that it waited for included
};

} // namespace isosurface

#endif
