// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PictureDelivery_h
#define isosurface_PictureDelivery_h

#include "Viewport/PixelRectangle.h"

#include "vtkSmartPointer.h"

#include <cstdint>
#include <vector>

class vtkOpenGLFramebufferObject;
class vtkOpenGLRenderer;
class vtkOpenGLRenderWindow;

namespace isosurface
{

/**
 * Puts a merged picture over a renderer's background, bit for bit as
 * vtkSynchronizedRenderers::vtkRawImage::PushToViewport() does by blending. That draws the picture
 * as a textured rectangle, into which software puts most of the time of a large frame; where the
 * background has one color and nothing is translucent, here memory is copied instead.
 */
class PictureDelivery
{
public:
  /**
   * `colors` are the renderer's size, width x height, row by row from the bottom up; nothing was
   * drawn outside of `covered`. False, with nothing done, where copying does not do: for gradient
   * and textured backgrounds, layers that draw over others, multisamples, framebuffers of other
   * than four bytes a pixel, and translucent pixels.
   */
  bool Deliver(vtkOpenGLRenderer* renderer, const std::uint32_t* colors, int width, int height,
    const PixelRectangle& covered);

private:
  bool PutOverBackground(
    const std::uint32_t* colors, int width, const PixelRectangle& part, std::uint32_t background);
  void Upload(vtkOpenGLRenderWindow* window, const PixelRectangle& part);

  std::vector<std::uint32_t> Pixels;
  vtkSmartPointer<vtkOpenGLFramebufferObject> Framebuffer; ///< the part, from its corner (0, 0) on
};

} // namespace isosurface

#endif
