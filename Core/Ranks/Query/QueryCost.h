// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_QueryCost_h
#define isosurface_QueryCost_h

#include "Ranks/Query/LevelChoice.h"
#include "Storage/Store/QueryStatistics.h"

#include <cstdint>
#include <optional>

namespace isosurface
{

/// The cost of a query on one rank.
struct QueryCost
{
  QueryStatistics Reading;
  std::uint64_t Triangles = 0;
  int Level = 0;                     ///< of the surface
  std::optional<LevelChoice> Choice; ///< of the level, within a budget
  double ExtractSeconds = 0; ///< wall clock of extraction, with the reading that it waited for
};

} // namespace isosurface

#endif
