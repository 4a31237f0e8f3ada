// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMetabufferPass
 * @brief   composites pictures that ranks draw in viewports and resolutions of their own
 *
 * A vtkIceTCompositePass for ranks that each have a part of a scene. Each rank draws only the
 * rectangle of the display that its props cover, one sample for each block of Divisor x Divisor
 * pixels, and reads back only that. The pictures are merged by depth; viewports may overlap, lie
 * across the tiles of a wall and change from frame to frame.
 *
 * With all divisors 1 the result is that of drawing the whole display, pixel for pixel, on a wall
 * as well. With other divisors each sample counts for all pixels of its block.
 *
 * Two ways of merging give the same picture: DIRECT_SEND exchanges active pixels in the resolution
 * that they were drawn in (see isosurface::ViewportCompositor); ICET gives IceT pictures of full
 * resolution whose valid pixels are the viewport.
 *
 * Where viewports cannot be used, all is as in vtkIceTCompositePass: with ordered compositing
 * (translucent geometry, volumes), float values, selections, data on all ranks, image reduction,
 * empty images that are to be rendered, another framebuffer, and displays of more than 16384
 * pixels.
 *
 * Every rank renders, with the same settings. An error of one rank ends the frame on all.
 *
 * After: W. Blanke, C. Bajaj, D. Fussell, X. Zhang, "The Metabuffer: a scalable multiresolution
 * multidisplay 3-D graphics system using commodity rendering engines", 2000.
 */

#ifndef vtkMetabufferPass_h
#define vtkMetabufferPass_h

#include "IsosurfaceRenderingModule.h" // For export macro
#include "vtkIceTCompositePass.h"

#include <memory> // For the implementation

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
    FULL_DISPLAY, ///< every rank draws all of the display
    BOUNDS        ///< every rank draws the rectangle that its props cover
  };
  ///@{
  /// What a rank draws. BOUNDS by default.
  vtkSetClampMacro(ViewportMode, int, FULL_DISPLAY, BOUNDS);
  vtkGetMacro(ViewportMode, int);
  ///@}

  enum CompositeModes
  {
    ICET,
    DIRECT_SEND
  };
  ///@{
  /// How pictures are merged. DIRECT_SEND by default.
  vtkSetClampMacro(CompositeMode, int, ICET, DIRECT_SEND);
  vtkGetMacro(CompositeMode, int);
  ///@}

  ///@{
  /**
   * The resolutions by rank: 1 for each pixel a sample, d for each block of d x d pixels, at most
   * 64. Ranks behind the end of the list have the last one of it; all have 1 by default.
   */
  void SetNumberOfDivisors(int count);
  int GetNumberOfDivisors() const;
  void SetDivisor(int index, int divisor);
  int GetDivisor(int index) const;
  ///@}

  ///@{
  /**
   * Seconds that a frame may take, or 0 (the default) if that does not matter. Resolutions are then
   * chosen for each frame, from 1 (each pixel) to 16, in the place of the divisors: the background,
   * what is far from the display's middle, and large parts before small ones, lose theirs first.
   * What frames take, and with what work, is learned from all frames, with and without a budget.
   * (See isosurface::ResolutionChooser.)
   */
  vtkSetClampMacro(FrameTimeBudget, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(FrameTimeBudget, double);
  ///@}

  ///@{
  /**
   * Whether each block is drawn with 2 x 2 samples, whose mean is shown. Lines and points are half
   * as wide then. Images are merged before the mean is taken, by DIRECT_SEND. Not done for
   * displays of more than 8192 pixels in a direction. Off by default.
   */
  vtkSetMacro(AntiAliasing, bool);
  vtkGetMacro(AntiAliasing, bool);
  vtkBooleanMacro(AntiAliasing, bool);
  ///@}

  ///@{
  /**
   * Whether colors go over linearly from block to block, in the place of blocks of one color.
   * Images are then enlarged before they are sent, hence as large as at full resolution. Off by
   * default.
   */
  vtkSetMacro(SmoothEnlarging, bool);
  vtkGetMacro(SmoothEnlarging, bool);
  vtkBooleanMacro(SmoothEnlarging, bool);
  ///@}

  ///@{
  /**
   * Whether the merged depths are wanted (GetLastRenderedDepths), as vtkIceTCompositePass always
   * provides them; without, less is sent. They are there in any case with DisplayDepthResults. On
   * by default.
   */
  vtkSetMacro(CollectDepths, bool);
  vtkGetMacro(CollectDepths, bool);
  vtkBooleanMacro(CollectDepths, bool);
  ///@}

  ///@{
  /// Whether the ranks' viewports are outlined in the picture, each in a color of its own. Off by
  /// default.
  vtkSetMacro(ShowViewports, bool);
  vtkGetMacro(ShowViewports, bool);
  vtkBooleanMacro(ShowViewports, bool);
  ///@}

  ///@{
  /**
   * Whether to wait for the graphics card and all ranks between the steps of a frame, so that the
   * seconds of each are its own. Off by default.
   */
  vtkSetMacro(MeasureSteps, bool);
  vtkGetMacro(MeasureSteps, bool);
  vtkBooleanMacro(MeasureSteps, bool);
  ///@}

  /// What the last frame cost this rank.
  struct FrameCost
  {
    double RenderSeconds;    ///< without MeasureSteps, of telling the graphics card what to draw
    double ReadSeconds;      ///< of reading back
    double CompositeSeconds; ///< of all of merging, of which by direct send:
    double EncodeSeconds;    ///< packing active pixels
    double ExchangeSeconds;  ///< sending and receiving, waiting for other ranks included
    double MergeSeconds;     ///< comparing depths
    double DeliverSeconds;   ///< putting pixels into the tile's picture
    double FrameSeconds;     ///< of all of Render()
    long long DisplayPixels; ///< that the viewport covers
    long long DrawnPixels;   ///< drawn and read back
    long long BytesSent;     ///< to other ranks
  };
  /**
   * Seconds of the last frame as the viewer sees it, if that is known to be more than this pass: of
   * the passing on of the picture, too. For FrameTimeBudget.
   */
  void SetLastFrameSeconds(double seconds);

  /// Valid if GetUsedViewports(); all 0 otherwise.
  const FrameCost& GetFrameCost() const;

  /// Whether viewports were used in the last frame; otherwise it was the superclass'.
  bool GetUsedViewports() const;

  /**
   * The viewport of a rank in the last frame: x, y, width, height in pixels of the display, and the
   * divisor. Known on every rank. All 0 if the rank drew nothing, or does not exist.
   */
  void GetViewport(int rank, int viewport[5]) const;

  /// Whether this rank shows a tile of the display; true if viewports were not used.
  bool ShowsTile() const;

  /**
   * The rectangle of this rank's tile outside of which nothing was drawn in the last frame: x, y,
   * width, height in pixels of the tile.
   */
  void GetCoveredPixels(int rectangle[4]) const;

  ///@{
  /**
   * Whether the renderer is told not to erase before this pass, which then erases what it draws to:
   * its viewport, or everything where it uses none. Off by default.
   */
  vtkSetMacro(ErasesDisplay, bool);
  vtkGetMacro(ErasesDisplay, bool);
  ///@}

protected:
  vtkMetabufferPass();
  ~vtkMetabufferPass() override;

  int ViewportMode = BOUNDS;
  int CompositeMode = DIRECT_SEND;
  double FrameTimeBudget = 0;
  bool AntiAliasing = false;
  bool SmoothEnlarging = false;
  bool CollectDepths = true;
  bool ShowViewports = false;
  bool MeasureSteps = false;
  bool ErasesDisplay = false;

private:
  vtkMetabufferPass(const vtkMetabufferPass&) = delete;
  void operator=(const vtkMetabufferPass&) = delete;

  bool CanUseViewports(const vtkRenderState* state);
  /// False if the display is too large; then nothing was done.
  bool RenderViewport(const vtkRenderState* state);
  /// Collective: all ranks' viewports of this frame; true if one of the ranks wants depths.
  bool AgreeOnViewports(const vtkRenderState* state);
  /// Collective: draws and merges; LastRendered... have this rank's tile afterwards.
  void DrawAndMerge(const vtkRenderState* state, bool wantsDepths);

  class Internals;
  std::unique_ptr<Internals> Internal;
};

#endif
