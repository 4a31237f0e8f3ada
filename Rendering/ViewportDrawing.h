// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ViewportDrawing_h
#define isosurface_ViewportDrawing_h

#include "Ground/Base/Status.h"
#include "Ranks/Compositing/Image.h"
#include "Ranks/Compositing/DisplayLayout.h"

#include "vtkSmartPointer.h"

#include <cstdint>
#include <vector>

class vtkMatrix4x4;
class vtkOpenGLFramebufferObject;
class vtkOpenGLRenderWindow;
class vtkRenderPass;
class vtkRenderState;
class vtkWindow;

namespace isosurface
{

/**
 * Draws the rectangle of a display that a viewport covers, and reads it back. The display may be
 * larger than the window, as on a wall.
 *
 * The result is identical to that rectangle of an image of the whole display: props are drawn on the
 * raster of the whole display, and a scissor keeps the pixels of the viewport. (A projection of the
 * viewport alone would move vertices by rounding errors, and change some pixels.) At divisor d the
 * raster has a pixel for each block of d x d pixels. Where d does not divide the display's size, the
 * raster is that of the next larger size which it divides.
 */
class ViewportDrawing
{
public:
  /// The maximum width and height of a display: what graphics cards support.
  static constexpr int MaximumDisplay = 16384;

  ViewportDrawing();
  ~ViewportDrawing();

  /**
   * Draws by `pass` with the renderer's active camera. The renderer is as before afterwards.
   * OutOfMemory if the graphics card or the pass has not enough memory; InvalidArgument if the pass
   * throws another exception. After an error there is nothing to read.
   */
  Status Draw(const vtkRenderState* state, vtkRenderPass* pass, const PixelRectangle& display,
    const Viewport& viewport);

  /// Reads back what the last Draw() has drawn, into memory that Draw() took. The image is valid
  /// until the next call.
  ImageView Read(const vtkRenderState* state, const Viewport& viewport);

  void ReleaseGraphicsResources(vtkWindow* window);

private:
  bool BindLargeFramebuffer(vtkOpenGLRenderWindow* window, int columns, int rows);
  void UnbindLargeFramebuffer(vtkOpenGLRenderWindow* window);
  void DrawRaster(const vtkRenderState* state, vtkRenderPass* pass, const PixelRectangle& display,
    const PixelRectangle& raster, const Viewport& viewport);

  vtkSmartPointer<vtkOpenGLFramebufferObject> LargeFramebuffer;
  bool IsLargeFramebufferBound = false;
  std::vector<std::uint32_t> Colors;
  std::vector<float> Depths;
};

} // namespace isosurface

#endif
