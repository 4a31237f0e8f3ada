// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BoundsProjection_h
#define isosurface_BoundsProjection_h

#include "Compositing/PixelRectangle.h"

#include <array>

namespace isosurface
{

/// What a box of the world covers on a display.
struct ProjectedBounds
{
  PixelRectangle Pixels;  ///< empty if nothing of the box is to be seen
  double NearDepth = 1.0; ///< normalized device depth, -1 (near plane) to 1 (far plane)
  double FarDepth = -1.0;
};

/**
 * The smallest rectangle of pixels of `display` that contains the projection of all points of a box
 * that are in front of the near plane, widened by `margin` pixels on each side, for lines and
 * points that are wider than the geometry that they show.
 *
 * `bounds` are x0, x1, y0, y1, z0, z1, empty if one begins behind its end. `worldToClip` is row by
 * row, for column vectors: projection times model-view, perspective or orthographic, which takes
 * the frustum to the cube -w <= x, y, z <= w; x = -w is the display's left edge. A box with values
 * that are not finite is taken to cover all of the display: it is drawn rather than lost.
 */
ProjectedBounds ProjectBounds(const std::array<double, 6>& bounds,
  const std::array<double, 16>& worldToClip, const PixelRectangle& display, double margin = 0);

} // namespace isosurface

#endif
