// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CompositePlan_h
#define isosurface_CompositePlan_h

#include "Ranks/Compositing/DisplayLayout.h"

#include <cstddef>
#include <vector>

namespace isosurface
{

/**
 * A rectangle of a tile that the same ranks cover completely. One of them, the owner, merges the
 * images of all and sends the result to the rank that shows the tile.
 */
struct CompositeCell
{
  std::size_t Tile = 0;   ///< index of the tile
  PixelRectangle Pixels;  ///< of the display, inside the tile
  std::vector<int> Ranks; ///< those whose viewports cover it, ascending, at least one
  int Owner = 0;          ///< one of them
  int Divisor = 1;        ///< of the merged image: the greatest common divisor of the ranks' ones

  /// The raster of the merged image, in blocks of Divisor.
  PixelRectangle GetBlocks() const { return CoverWithBlocks(this->Pixels, this->Divisor); }
};

/**
 * Cuts the tiles into cells along the edges of the viewports. Cells that several ranks cover are cut
 * further, into strips whose owners have about equal work. Each pixel of a tile that some viewport
 * covers is in one cell of that tile; all other pixels are in none.
 *
 * `viewports` are those of all ranks, by rank; that of a rank that draws nothing is empty. The plan
 * depends on the arguments alone, so it is the same on every rank.
 *
 * A cell that one rank covers needs no merging: that rank sends colors only, to the rank that shows
 * the tile. Compact pieces of a surface have mostly such cells.
 *
 * Cost for n viewports that all overlap: O(n^2) cells a tile, of up to n ranks each.
 */
std::vector<CompositeCell> PlanCompositing(
  const std::vector<Viewport>& viewports, const std::vector<DisplayTile>& tiles);

} // namespace isosurface

#endif
