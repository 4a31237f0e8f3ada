// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ViewportDrawing_h
#define isosurface_ViewportDrawing_h

#include "Base/Status.h"
#include "Compositing/BoundsProjection.h"
#include "Compositing/PixelRuns.h"
#include "Compositing/Viewport.h"

#include "vtkNew.h"
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
 * Draws what a renderer shows into a viewport of a display and reads it back. The display may be
 * larger than the window (a wall of several).
 *
 * Pixel for pixel the result is a part of the picture of the whole display: everything is drawn on
 * the raster of the whole display, of whose pixels all but the viewport's are cut away. (A
 * projection of the viewport alone would move vertices by rounding errors, and with them a few
 * pixels.) At divisor d that raster has a pixel for each block of d x d pixels; where d does not
 * divide the display's size, it is that of the next larger display that it does divide, of which
 * this one is the low left part.
 */
class ViewportDrawing
{
public:
  /// The largest display that can be drawn: what graphics cards bear.
  static constexpr int LargestDisplay = 16384;

  ViewportDrawing();
  ~ViewportDrawing();

  /**
   * Where the visible props that the state has are on the display, lines and points in their width
   * included, if one of their pixels is a block of divisor x divisor. Of props whose bounds do not
   * tell where they draw it is all of the display.
   */
  static ProjectedBounds FindBounds(
    const vtkRenderState* state, const PixelRectangle& display, int divisor);

  /// Distance from the camera of what is as far away as the bounds' depths say, in world units.
  static double GetDistance(const vtkRenderState* state, double depth);

  /// Cells of the visible props' polygonal data.
  static std::int64_t CountCells(const vtkRenderState* state);

  /**
   * Draws by `pass` with the renderer's active camera; the state's renderer is as before, after it.
   * Fails with OutOfMemory if the graphics card or the pass have not enough, or InvalidArgument if
   * the pass throws anything else; then there is nothing to read.
   */
  Status Draw(const vtkRenderState* state, vtkRenderPass* pass, const PixelRectangle& display,
    const Viewport& viewport);

  /// Reads back what was drawn. The picture is valid until the next one is read.
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
