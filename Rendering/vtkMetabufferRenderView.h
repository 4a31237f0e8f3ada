// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMetabufferRenderView
 * @brief   ParaView's render view with each rank's viewport and resolution its own
 *
 * A vtkPVRenderView whose ranks' pictures a vtkMetabufferPass merges. At full resolution it shows
 * the same picture, pixel for pixel, for less. Annotations are drawn over it as ever, by the
 * process that shows it. What the pass cannot do (translucent geometry, volumes, selection) it
 * leaves to stock compositing.
 *
 * All settings are made on all processes; those without a pass ignore them: clients, and ranks that
 * are alone, which draw as in the stock view.
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

  /// vtkMetabufferPass::ViewportModes.
  void SetViewportMode(int mode);

  enum ResolutionModes
  {
    FULL,
    PER_RANK,
    TIME_BUDGET
  };
  ///@{
  /// Whether all ranks draw a sample for each pixel (the default), or as the divisors say, or such
  /// that frames keep their time while the camera moves; still frames are full ones then.
  void SetResolutionMode(int mode);
  vtkGetMacro(ResolutionMode, int);
  ///@}

  ///@{
  /// The resolutions of PER_RANK; see vtkMetabufferPass::SetDivisor().
  void SetNumberOfDivisors(int count);
  void SetDivisor(int index, int divisor);
  ///@}

  ///@{
  /// Seconds of TIME_BUDGET for a frame; 0.1 by default. See vtkMetabufferPass::FrameTimeBudget.
  vtkSetClampMacro(FrameTimeBudget, double, 0.001, VTK_DOUBLE_MAX);
  vtkGetMacro(FrameTimeBudget, double);
  ///@}

  /// Whether pixels are means of 2 x 2 samples, and blocks go over into each other; see
  /// vtkMetabufferPass.
  void SetAntiAliasing(bool antiAliasing);
  void SetSmoothEnlarging(bool smoothEnlarging);

  /// Whether the ranks' viewports are outlined in the picture.
  void SetShowViewports(bool show);

  /**
   * Collects the depths of a frame, which are not kept of others, hence draws one more. (Hides the
   * superclass' function, which ParaView calls by its name, on all processes.)
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
