// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Background_h
#define isosurface_Background_h

#include "Ranks/Compositing/DisplayLayout.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Copies the colors of a rectangle of an image over a background of one color: opaque pixels are
 * copied, all others get the background. `colors` are those of the image, whose rows have `width`
 * pixels; `result` becomes those of the rectangle. False if a pixel is neither opaque nor 0; such
 * pixels would have to be blended.
 */
bool PutOverBackground(const std::uint32_t* colors, int width, const PixelRectangle& rectangle,
  std::uint32_t background, std::vector<std::uint32_t>& result);

} // namespace isosurface

#endif
