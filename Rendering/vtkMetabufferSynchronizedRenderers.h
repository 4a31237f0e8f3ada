// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMetabufferSynchronizedRenderers
 * @brief   synchronizes renderers of several ranks, merging their pictures by a vtkMetabufferPass
 *
 * Used as vtkIceTSynchronizedRenderers, beside a vtkSynchronizedRenderWindows; the class is all
 * that an application without a ParaView session needs. Windows must not have multisamples.
 *
 * Only what is seen is cleared, drawn and shown: windows of ranks that have no tile of the display
 * keep what they had.
 */

#ifndef vtkMetabufferSynchronizedRenderers_h
#define vtkMetabufferSynchronizedRenderers_h

#include "IsosurfaceRenderingModule.h" // For export macro
#include "vtkIceTSynchronizedRenderers.h"
#include "vtkNew.h" // For FXAA

#include <memory> // For the delivery

namespace isosurface
{
class ImageDelivery;
}
class vtkMetabufferPass;
class vtkOpenGLFXAAFilter;

class ISOSURFACERENDERING_EXPORT vtkMetabufferSynchronizedRenderers
  : public vtkIceTSynchronizedRenderers
{
public:
  static vtkMetabufferSynchronizedRenderers* New();
  vtkTypeMacro(vtkMetabufferSynchronizedRenderers, vtkIceTSynchronizedRenderers);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The pass that merges, for its settings.
  vtkMetabufferPass* GetMetabufferPass();

protected:
  vtkMetabufferSynchronizedRenderers();
  ~vtkMetabufferSynchronizedRenderers() override;

  /// The pass erases what it draws, in the place of the superclass' camera pass.
  void HandleStartRender() override;
  void HandleEndRender() override;
  /// By copying where that gives the superclass' picture.
  void PushImageToScreen() override;

private:
  vtkMetabufferSynchronizedRenderers(const vtkMetabufferSynchronizedRenderers&) = delete;
  void operator=(const vtkMetabufferSynchronizedRenderers&) = delete;

  bool IsActive() const;
  /// The window has shown the frame, or, where it shows no tile, done without.
  void HandleEndOfFrame(vtkObject* window, unsigned long event, void* data);

  std::unique_ptr<isosurface::ImageDelivery> Delivery;
  vtkNew<vtkOpenGLFXAAFilter> Antialiasing;
  bool WantsFXAA = false;
  bool DoesErase = false;
  bool IsFrameHidden = false;
  unsigned long EndOfFrameObserver = 0;
  double BeginOfFrame = 0;
};

#endif
