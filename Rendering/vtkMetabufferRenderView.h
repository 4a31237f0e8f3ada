// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMetabufferRenderView
 * @brief   ParaView's render view, whose ranks draw viewports at resolutions of their own
 *
 * A vtkPVRenderView that merges the ranks' images by a vtkMetabufferPass. At full resolution the image
 * is that of the stock view, pixel for pixel. The process that shows the view draws annotations over
 * it, as in the stock view. What the pass does not support (translucent geometry, volumes,
 * selections) is composited as in the stock view.
 *
 * All settings are made on all processes. Clients and single ranks, which have no pass, ignore them
 * and draw as in the stock view.
 */

#ifndef vtkMetabufferRenderView_h
#define vtkMetabufferRenderView_h

#include "IsosurfaceRenderingModule.h" // For export macro
#include "vtkPVRenderView.h"

#include <vector> // For divisors

class vtkMetabufferPass;

class ISOSURFACERENDERING_EXPORT vtkMetabufferRenderView : public vtkPVRenderView
{
public:
  static vtkMetabufferRenderView* New();
  vtkTypeMacro(vtkMetabufferRenderView, vtkPVRenderView);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// What a rank draws, one of vtkMetabufferPass::ViewportModes.
  void SetViewportMode(int mode);
  /// How images are merged, one of vtkMetabufferPass::CompositeModes.
  void SetCompositeMode(int mode);

  enum ResolutionModes
  {
    FULL,       ///< one sample for each pixel
    PER_RANK,   ///< by the divisors
    TIME_BUDGET ///< chosen for each frame while the camera moves; FULL when it rests
  };
  ///@{
  /// The resolutions of the ranks. FULL by default.
  void SetResolutionMode(int mode);
  vtkGetMacro(ResolutionMode, int);
  ///@}

  ///@{
  /// The resolutions of PER_RANK; see vtkMetabufferPass::SetDivisor().
  void SetNumberOfDivisors(int count);
  void SetDivisor(int index, int divisor);
  ///@}

  ///@{
  /// The seconds that a frame may take with TIME_BUDGET; 0.1 by default. See vtkMetabufferPass.
  vtkSetClampMacro(FrameTimeBudget, double, 0.001, VTK_DOUBLE_MAX);
  vtkGetMacro(FrameTimeBudget, double);
  ///@}

  /// Whether pixels are means of 2 x 2 samples, and whether colors are interpolated between blocks.
  /// See vtkMetabufferPass.
  void SetAntiAliasing(bool antiAliasing);
  void SetSmoothUpsampling(bool smoothUpsampling);

  /// Whether the ranks' viewports are outlined in the image.
  void SetShowViewports(bool show);

  /**
   * Draws one more frame to collect its depths: other frames do without. (Hides the superclass'
   * function; ParaView calls it by name on all processes.)
   */
  void CaptureZBuffer();

protected:
  vtkMetabufferRenderView();
  ~vtkMetabufferRenderView() override;

  void AboutToRenderOnLocalProcess(bool interactive) override;

  int ResolutionMode = FULL;
  double FrameTimeBudget = 0.1;
  std::vector<int> Divisors;

private:
  vtkMetabufferRenderView(const vtkMetabufferRenderView&) = delete;
  void operator=(const vtkMetabufferRenderView&) = delete;

  vtkMetabufferPass* GetPass();
  void UpdateResolution();
};

#endif
