// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMetabufferPass
 * @brief   composites images that ranks draw in viewports and resolutions of their own
 *
 * Each rank draws and reads back the rectangle of the display that its props cover, one sample for
 * each block of Divisor x Divisor pixels. The images are merged by depth. Viewports may overlap and
 * lie across the tiles of a wall. With all divisors 1 the result is identical to an image that one
 * rank draws of all props, on a wall as well.
 *
 * All ranks render, with the same settings. An error of one rank ends the frame on all ranks. What
 * the pass does not support is drawn as by vtkIceTCompositePass; see CanUseViewports().
 *
 * After: W. Blanke, C. Bajaj, D. Fussell, X. Zhang, "The Metabuffer: a scalable multiresolution
 * multidisplay 3-D graphics system using commodity rendering engines", 2000.
 */

#ifndef vtkMetabufferPass_h
#define vtkMetabufferPass_h

#include "IsosurfaceRenderingModule.h" // For export macro
#include "vtkIceTCompositePass.h"

#include <memory> // For the implementation

namespace isosurface
{
class Status;
}

class ISOSURFACERENDERING_EXPORT vtkMetabufferPass : public vtkIceTCompositePass
{
public:
  static vtkMetabufferPass* New();
  vtkTypeMacro(vtkMetabufferPass, vtkIceTCompositePass);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void Render(const vtkRenderState* state) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;

  enum ViewportModes
  {
    FULL_DISPLAY, ///< every rank draws the whole display
    BOUNDS        ///< every rank draws the rectangle that its props cover
  };
  ///@{
  /// What a rank draws. BOUNDS by default.
  vtkSetClampMacro(ViewportMode, int, FULL_DISPLAY, BOUNDS);
  vtkGetMacro(ViewportMode, int);
  ///@}

  enum CompositeModes
  {
    ICET,       ///< by IceT: every rank sends images of full resolution
    DIRECT_SEND ///< ranks send active pixels, in the resolution that they were drawn in
  };
  ///@{
  /// How images are merged. DIRECT_SEND by default. The result is the same.
  vtkSetClampMacro(CompositeMode, int, ICET, DIRECT_SEND);
  vtkGetMacro(CompositeMode, int);
  ///@}

  ///@{
  /**
   * The resolutions by rank, from 1 (one sample for each pixel) to 64 (one for each block of 64 x 64
   * pixels). Ranks beyond the end of the list have its last divisor. All have 1 by default.
   */
  void SetNumberOfDivisors(int count);
  int GetNumberOfDivisors() const;
  void SetDivisor(int index, int divisor);
  int GetDivisor(int index) const;
  ///@}

  ///@{
  /**
   * The seconds that a frame may take; 0, the default: no limit. With a budget the divisors, from
   * 1 to 16, are chosen for each frame: the background, viewports far from the display's center, and
   * large ones lose resolution first. The pass learns the seconds of frames from all frames.
   */
  vtkSetClampMacro(FrameTimeBudget, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(FrameTimeBudget, double);
  ///@}

  ///@{
  /**
   * Whether each block is drawn with 2 x 2 samples, whose mean is shown. Lines and points are half
   * as wide then. Always merges by DIRECT_SEND. Ignored for displays of more than 8192 pixels in a
   * direction. Off by default.
   */
  vtkSetMacro(AntiAliasing, bool);
  vtkGetMacro(AntiAliasing, bool);
  vtkBooleanMacro(AntiAliasing, bool);
  ///@}

  ///@{
  /**
   * Whether colors are interpolated between blocks. Ranks then upsample their images before they
   * send them, so they send as much as at full resolution. Off by default.
   */
  vtkSetMacro(SmoothUpsampling, bool);
  vtkGetMacro(SmoothUpsampling, bool);
  vtkBooleanMacro(SmoothUpsampling, bool);
  ///@}

  ///@{
  /**
   * Whether the merged depths are collected (GetLastRenderedDepths), as vtkIceTCompositePass always
   * does. Without them ranks send less. DisplayDepthResults collects them in any case. On by default.
   */
  vtkSetMacro(CollectDepths, bool);
  vtkGetMacro(CollectDepths, bool);
  vtkBooleanMacro(CollectDepths, bool);
  ///@}

  ///@{
  /**
   * Whether ranks tell each other the depths of large opaque surfaces while they draw, so that each
   * leaves out what is behind others'; see vtkIsosurfaceMapper::SetOcclusionCulling. The image is
   * the same. Only in full resolution. On by default.
   */
  vtkSetMacro(ShareDepths, bool);
  vtkGetMacro(ShareDepths, bool);
  vtkBooleanMacro(ShareDepths, bool);
  ///@}

  ///@{
  /// Whether the ranks' viewports are outlined in the image, each in its own color. Off by default.
  vtkSetMacro(ShowViewports, bool);
  vtkGetMacro(ShowViewports, bool);
  vtkBooleanMacro(ShowViewports, bool);
  ///@}

  ///@{
  /**
   * Whether the pass, not the renderer, erases the pixels that the pass draws to: its viewport or the
   * whole display. Off by default.
   */
  vtkSetMacro(ErasesDisplay, bool);
  vtkGetMacro(ErasesDisplay, bool);
  ///@}

  /**
   * Tells the pass how long the last frame took for the viewer, if that is more than Render() took:
   * delivery of the image included. Used to keep FrameTimeBudget.
   */
  void SetLastFrameSeconds(double seconds);

  ///@{
  /// What the last frame cost this rank: seconds for reading back, pixels drawn and read back, bytes
  /// sent to other ranks. 0 if viewports were not used.
  double GetReadSeconds() const;
  vtkTypeInt64 GetDrawnPixels() const;
  vtkTypeInt64 GetBytesSent() const;
  ///@}

  /// Whether viewports were used in the last frame; if not, the superclass rendered it.
  bool GetUsedViewports() const;

  /**
   * The viewport of any rank in the last frame: x, y, width, height in pixels of the display, and the
   * divisor. Known on all ranks. All 0 if the rank drew nothing or does not exist.
   */
  void GetViewport(int rank, int viewport[5]) const;

  /// Whether this rank shows a tile of the display; true if viewports were not used.
  bool ShowsTile() const;

  /**
   * The rectangle of this rank's tile outside of which nothing was drawn in the last frame: x, y,
   * width, height in pixels of the tile.
   */
  void GetCoveredPixels(int rectangle[4]) const;

protected:
  vtkMetabufferPass();
  ~vtkMetabufferPass() override;

  int ViewportMode = BOUNDS;
  int CompositeMode = DIRECT_SEND;
  double FrameTimeBudget = 0;
  bool AntiAliasing = false;
  bool SmoothUpsampling = false;
  bool CollectDepths = true;
  bool ShareDepths = true;
  bool ShowViewports = false;
  bool ErasesDisplay = false;

private:
  vtkMetabufferPass(const vtkMetabufferPass&) = delete;
  void operator=(const vtkMetabufferPass&) = delete;

  /**
   * False with ordered compositing (translucent geometry, volumes), float values, selections, data
   * on all ranks, image reduction, empty images that are to be rendered, ambient occlusion, and another
   * framebuffer.
   */
  bool CanUseViewports(const vtkRenderState* state);
  /// Collective. If the display is too large for viewports, UsedViewports is false, and nothing was
  /// drawn. An error of one rank is one of all.
  isosurface::Status RenderViewports(const vtkRenderState* state);
  /// Finds the tiles of the display.
  void SetUpDisplay(const vtkRenderState* state);
  /// Collective: draws all viewports of a frame and merges them to the last rendered image.
  isosurface::Status DrawFrame(const vtkRenderState* state);
  /// Leaves no image, and reports the error unless it is another rank's.
  void FailFrame(const vtkRenderState* state, const isosurface::Status& status);

  class Internals;
  std::unique_ptr<Internals> Internal;
};

#endif
