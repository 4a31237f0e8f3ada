// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BoundsProjection_h
#define isosurface_BoundsProjection_h

#include "Ranks/Compositing/DisplayLayout.h"

#include <array>

namespace isosurface
{

/// What a box in world coordinates covers on a display.
struct ProjectedBounds
{
  PixelRectangle Pixels;  ///< empty if nothing of the box is visible
  double NearDepth = 1.0; ///< normalized device depth, -1 (near plane) to 1 (far plane)
  double FarDepth = -1.0;
};

/**
 * The smallest rectangle of pixels of `display` that contains the projection of all points of a box
 * in front of the near plane, extended by `margin` pixels on each side (for lines and points).
 *
 * `bounds` are x0, x1, y0, y1, z0, z1; the box is empty if a minimum exceeds its maximum.
 * `worldToClip` is the product of projection and model-view matrix, perspective or orthographic, row
 * by row, for column vectors. The frustum is -w <= x, y, z <= w; x = -w is the display's left edge.
 * A box with values that are not finite covers the whole display, so that it is not lost.
 */
ProjectedBounds ProjectBounds(const std::array<double, 6>& bounds,
  const std::array<double, 16>& worldToClip, const PixelRectangle& display, double margin = 0);

} // namespace isosurface

#endif
