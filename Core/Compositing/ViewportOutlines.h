// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ViewportOutlines_h
#define isosurface_ViewportOutlines_h

#include "Compositing/Viewport.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// The color of a rank's outline: opaque, bytes red, green, blue, alpha in the order of addresses.
/// Ranks that follow each other have hues far apart.
std::uint32_t GetOutlineColor(int rank);

/**
 * Draws the edges of the viewports over a tile's picture, inside of them, two pixels wide, each in
 * its rank's color: as a full line at full resolution, else in dashes as long as four blocks. Of
 * lines in the same place that of the highest rank is seen.
 *
 * `colors` are those of `tile`, row by row from the bottom up.
 */
void DrawViewportOutlines(const std::vector<Viewport>& viewports, const PixelRectangle& display,
  const PixelRectangle& tile, std::uint32_t* colors);

} // namespace isosurface

#endif
