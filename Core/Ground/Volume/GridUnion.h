// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GridUnion_h
#define isosurface_GridUnion_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/GridGeometry.h"

#include <cstddef>
#include <vector>

namespace isosurface
{

/// What an error of a shortage of memory says.
constexpr const char* NoMemoryForGrids = "the grids of all ranks cannot be united";

/// The grids of this rank's pieces, for UniteGrids.
Message PackGrids(const std::vector<GridGeometry>& pieces);

/**
 * The grids of which all ranks have pieces; `packed` is what PackGrids gives on each. Pieces of equal
 * origin, spacing and direction belong to one grid, whose extent is the box around them. The grids are
 * ordered by origin, spacing and direction, so that all ranks get the same list.
 */
std::vector<GridGeometry> UniteGrids(const std::vector<Message>& packed);

/// The number of a piece's grid in that list.
std::size_t FindGrid(const std::vector<GridGeometry>& grids, const GridGeometry& piece);

} // namespace isosurface

#endif
