// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Viewport_h
#define isosurface_Viewport_h

#include "Compositing/PixelRectangle.h"

#include <vector>

namespace isosurface
{

/// The coarsest resolution of a viewport: blocks of 64 x 64 pixels.
constexpr int LargestDivisor = 64;

/// The blocks of divisor x divisor pixels, counted from the display's pixel (0, 0), that have a
/// pixel in the rectangle. X and Y of the rectangle are not negative.
PixelRectangle CoverWithBlocks(const PixelRectangle& pixels, int divisor);

/**
 * The part of a display that one rank draws, at a resolution of its own: one sample for each block
 * of Divisor x Divisor pixels. Blocks of one divisor have the same places for all ranks: they are
 * counted from the display's low left pixel (0, 0), beyond whose right and upper edge the
 * last ones may reach. Any viewports may overlap; a viewport may lie across tiles.
 *
 * After: W. Blanke, C. Bajaj, D. Fussell, X. Zhang, "The Metabuffer: a scalable multiresolution
 * multidisplay 3-D graphics system using commodity rendering engines", 2000; here a viewport may be
 * smaller than the display that it is a viewport of at any resolution.
 */
struct Viewport
{
  int Divisor = 1;
  PixelRectangle Blocks; ///< in units of blocks; also the raster that the rank draws

  /// The pixels that it covers of a part of the display.
  PixelRectangle GetPixels(const PixelRectangle& part) const;

  bool operator==(const Viewport& other) const
  {
    return this->Divisor == other.Divisor && this->Blocks == other.Blocks;
  }
};

/// The smallest viewport of a resolution that covers `pixels`, which are part of the display.
Viewport MakeViewport(const PixelRectangle& pixels, int divisor);

/// A screen of a wall: its part of the display, and the rank that shows it.
struct DisplayTile
{
  PixelRectangle Pixels;
  int Rank = 0;
};

/// The smallest rectangle that begins at (0, 0) and contains all tiles.
PixelRectangle GetDisplay(const std::vector<DisplayTile>& tiles);

} // namespace isosurface

#endif
