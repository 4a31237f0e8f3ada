// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImageDelivery_h
#define isosurface_ImageDelivery_h

#include "Ranks/Compositing/PixelRectangle.h"

#include <cstdint>
#include <vector>

class vtkOpenGLRenderer;

namespace isosurface
{

/**
 * Puts a merged image over a renderer's background. The result is bit for bit that of
 * vtkSynchronizedRenderers::vtkRawImage::PushToViewport(), which blends a textured rectangle: in
 * software that takes most of the time of a large frame. Where the background has one color and
 * nothing is translucent, this copies memory instead.
 */
class ImageDelivery
{
public:
  /**
   * `colors` are width x height pixels, row by row from the bottom up; nothing was drawn outside of
   * `covered`. False, with the renderer's pixels undefined, if copying is not possible: for gradient
   * and textured backgrounds, layers over others, another size than the renderer's, multisamples,
   * stencils, framebuffers of other than four bytes a pixel, translucent pixels, and OpenGL that
   * cannot write textures (see DrawTextures).
   */
  bool Deliver(vtkOpenGLRenderer* renderer, const std::uint32_t* colors, int width, int height,
    const PixelRectangle& covered);

private:
  std::vector<std::uint32_t> Band; ///< some rows, put over the background
};

} // namespace isosurface

#endif
