// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Viewport_h
#define isosurface_Viewport_h

#include "Ranks/Compositing/PixelRectangle.h"

namespace isosurface
{

/// The coarsest resolution of a viewport: blocks of 64 x 64 pixels.
constexpr int MaximumDivisor = 64;

/// The blocks of divisor x divisor pixels that have a pixel in the rectangle. Blocks are counted from
/// the display's pixel (0, 0); X and Y of the rectangle are not negative.
PixelRectangle CoverWithBlocks(const PixelRectangle& pixels, int divisor);

/**
 * The rectangle of a display that one rank draws at a resolution of its own: one sample for each
 * block of Divisor x Divisor pixels. Blocks of one divisor have the same places on all ranks: they
 * are counted from the display's low left pixel (0, 0), and the last ones may reach beyond its right
 * and upper edges. Viewports may overlap; a viewport may lie across tiles.
 *
 * After: W. Blanke, C. Bajaj, D. Fussell, X. Zhang, "The Metabuffer: a scalable multiresolution
 * multidisplay 3-D graphics system using commodity rendering engines", 2000. Here a
 * viewport may have any size at any resolution.
 */
struct Viewport
{
  int Divisor = 1;
  PixelRectangle Blocks; ///< in units of blocks; also the raster that the rank draws

  /// The pixels of a rectangle of the display that the viewport covers.
  PixelRectangle GetPixels(const PixelRectangle& rectangle) const;

  bool operator==(const Viewport& other) const
  {
    return this->Divisor == other.Divisor && this->Blocks == other.Blocks;
  }
};

/// The smallest viewport of a resolution that covers `pixels`, a rectangle of the display.
Viewport MakeViewport(const PixelRectangle& pixels, int divisor);

} // namespace isosurface

#endif
