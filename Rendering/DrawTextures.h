// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DrawTextures_h
#define isosurface_DrawTextures_h

#include "Ranks/Compositing/DisplayLayout.h"

#include <cstdint>

namespace isosurface
{

/**
 * Clears and writes the textures of the current draw framebuffer as memory, which software renderers
 * do ten times as fast as drawing rectangles. Possible where the framebuffer has a color and a depth
 * texture, no stencil and one sample for a pixel, and OpenGL can write textures (4.5, or the
 * extensions). Scissor and color masks have no effect. The framebuffer's context must be current.
 */
class DrawTextures
{
public:
  /// Finds the textures of the framebuffer that is bound now.
  DrawTextures();

  /// Whether textures can be cleared.
  bool AreThere() const { return this->Color != 0 && this->Depth != 0; }
  /// Whether, in addition, a color has four bytes: red, green, blue, alpha.
  bool HavePlainColors() const { return this->AreThere() && this->IsPlain; }

  /// Sets plain colors; with 0 sets colors of any kind to black, transparent.
  void ClearColors(const PixelRectangle& rectangle, std::uint32_t color) const;
  /// Sets depths to 1, the far plane.
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
