// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DrawTextures_h
#define isosurface_DrawTextures_h

#include "Compositing/PixelRectangle.h"

#include <cstdint>

namespace isosurface
{

/**
 * The textures of the framebuffer that is drawn to, where it has a color and a depth texture, no
 * stencil, one sample for a pixel, and OpenGL allows to write to textures as memory (4.5, or the
 * extensions). Software renderers write memory ten times as fast as they draw rectangles.
 *
 * Neither scissor nor color masks count. Needs the context of the framebuffer to be current.
 */
class DrawTextures
{
public:
  /// Finds the textures of the framebuffer that is bound now.
  DrawTextures();

  /// If not, nothing may be cleared or put.
  bool AreThere() const { return this->Color != 0 && this->Depth != 0; }
  /// Whether a color is four bytes: red, green, blue, alpha.
  bool HavePlainColors() const { return this->AreThere() && this->IsPlain; }

  /// Sets plain colors, or, with 0, colors of any kind to black, transparent.
  void ClearColors(const PixelRectangle& rectangle, std::uint32_t color) const;
  /// Sets depths to the farthest, 1.
  void ClearDepths(const PixelRectangle& rectangle) const;
  /// Copies plain colors; rows have the rectangle's width.
  void PutColors(const PixelRectangle& rectangle, const std::uint32_t* colors) const;

private:
  unsigned int Color = 0;
  unsigned int Depth = 0;
  bool IsPlain = false;
};

} // namespace isosurface

#endif
