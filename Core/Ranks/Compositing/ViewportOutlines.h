// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ViewportOutlines_h
#define isosurface_ViewportOutlines_h

#include "Ranks/Compositing/DisplayLayout.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// The color of a rank's outline: opaque; bytes red, green, blue, alpha in the order of addresses.
/// Consecutive ranks have very different hues.
std::uint32_t GetOutlineColor(int rank);

/**
 * Draws the outlines of the ranks' viewports over the image of a tile: two pixels wide, inside the
 * viewport, in the rank's color. The line is solid at full resolution, else dashed, with dashes of
 * four blocks. Where lines coincide, that of the highest rank is seen.
 *
 * `colors` are the tile's pixels, row by row from the bottom up.
 */
void DrawViewportOutlines(const std::vector<Viewport>& viewports, const DisplayLayout& display,
  const DisplayTile& tile, std::uint32_t* colors);

} // namespace isosurface

#endif
