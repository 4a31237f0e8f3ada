// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DisplayLayout_h
#define isosurface_DisplayLayout_h

#include "Ranks/Compositing/PixelRectangle.h"

#include <vector>

namespace isosurface
{

/// A screen of a wall: its rectangle of the display, and the rank that shows it.
struct DisplayTile
{
  PixelRectangle Pixels;
  int Rank = 0;
};

/**
 * The display that the ranks draw together: one tile, or several on a wall. Ranks draw samples, tiles
 * show pixels; with antialiasing a pixel has 2 x 2 samples.
 */
struct DisplayLayout
{
  std::vector<DisplayTile> Tiles; ///< in samples, counted from the display's low left corner
  int SamplesPerPixel = 1;        ///< in each direction: 1, or 2 with antialiasing

  /// The smallest rectangle of samples that begins at (0, 0) and contains all tiles.
  PixelRectangle GetExtent() const;

  /// The tile that a rank shows; null if there is none.
  const DisplayTile* FindTile(int rank) const;

  /// The pixels that have one of the samples.
  PixelRectangle CoverWithPixels(const PixelRectangle& samples) const;
};

/// A display with `samplesPerPixel` samples for each pixel of the tiles, in each direction.
DisplayLayout MakeDisplayLayout(const std::vector<DisplayTile>& tiles, int samplesPerPixel);

} // namespace isosurface

#endif
