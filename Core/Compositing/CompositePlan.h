// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CompositePlan_h
#define isosurface_CompositePlan_h

#include "Compositing/Viewport.h"

#include <cstddef>
#include <vector>

namespace isosurface
{

/**
 * A part of a tile that the same ranks cover all over. One of them, the owner, merges the pictures
 * of all and passes the result on to the rank that shows the tile.
 */
struct CompositeCell
{
  std::size_t Tile = 0;   ///< index of the tile
  PixelRectangle Pixels;  ///< of the display, inside the tile
  std::vector<int> Ranks; ///< those whose viewports cover it, ascending, at least one
  int Owner = 0;          ///< one of them
  int Divisor = 1;        ///< of the merged picture: the greatest common one of the ranks' divisors

  /// The raster of the merged picture, in blocks of Divisor.
  PixelRectangle GetBlocks() const { return CoverWithBlocks(this->Pixels, this->Divisor); }
};

/**
 * Cuts the tiles along the edges of the viewports into cells, and those where pictures meet into
 * strips that are shared out evenly among the ranks that draw there. All that some viewport covers
 * is in one cell for each tile that it is on, all else in none.
 *
 * `viewports` are by rank; a rank that shows a tile has one, maybe empty. Every rank makes the same
 * plan of the same arguments.
 *
 * Where one rank draws alone, nothing has to be merged, and it needs to send colors only, to
 * nobody but the rank that shows the tile. Compact parts of a surface have mostly such cells.
 *
 * Cost for n viewports: O(n^2) cells of up to n ranks on a tile, where all overlap.
 */
std::vector<CompositeCell> PlanCompositing(
  const std::vector<Viewport>& viewports, const std::vector<DisplayTile>& tiles);

} // namespace isosurface

#endif
