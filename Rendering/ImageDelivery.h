// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImageDelivery_h
#define isosurface_ImageDelivery_h

#include "Compositing/PixelRectangle.h"

#include <cstdint>
#include <vector>

class vtkOpenGLRenderer;

namespace isosurface
{

/**
 * Puts a merged picture over a renderer's background, bit for bit as
 * vtkSynchronizedRenderers::vtkRawImage::PushToViewport() does by blending. That draws the picture
 * as a textured rectangle, into which software puts most of the time of a large frame; where the
 * background has one color and nothing is translucent, here memory is copied instead.
 */
class ImageDelivery
{
public:
  /**
   * `colors` are the renderer's size, width x height, row by row from the bottom up; nothing was
   * drawn outside of `covered`. False where copying does not do, which leaves the renderer's part
   * of the window undefined: for gradient and textured backgrounds, layers that draw over others,
   * multisamples, stencils, framebuffers of other than four bytes a pixel, translucent pixels, and
   * OpenGL that cannot write textures (see DrawTextures).
   */
  bool Deliver(vtkOpenGLRenderer* renderer, const std::uint32_t* colors, int width, int height,
    const PixelRectangle& covered);

private:
  bool PutOverBackground(
    const std::uint32_t* colors, int width, const PixelRectangle& band, std::uint32_t background);

  std::vector<std::uint32_t> Band;
};

} // namespace isosurface

#endif
