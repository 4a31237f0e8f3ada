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
    PER_RANK
  };
  ///@{
  /// Whether all ranks draw a sample for each pixel (the default), or as the divisors say.
  void SetResolutionMode(int mode);
  vtkGetMacro(ResolutionMode, int);
  ///@}

  ///@{
  /// The resolutions of PER_RANK; see vtkMetabufferPass::SetDivisor().
  void SetNumberOfDivisors(int count);
  void SetDivisor(int index, int divisor);
  ///@}

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

  int ResolutionMode = FULL;
  std::vector<int> Divisors;

private:
  vtkMetabufferRenderView(const vtkMetabufferRenderView&) = delete;
  void operator=(const vtkMetabufferRenderView&) = delete;

  vtkMetabufferPass* GetPass();
  void UpdateResolution();
};

#endif
