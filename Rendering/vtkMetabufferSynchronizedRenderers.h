// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMetabufferSynchronizedRenderers
 * @brief   synchronizes renderers of several ranks, and merges their images by a vtkMetabufferPass
 *
 * Used like vtkIceTSynchronizedRenderers, with a vtkSynchronizedRenderWindows. An application without
 * a ParaView session needs no other class of this module. Windows must not have multisamples.
 *
 * Windows of ranks without a tile of the display are neither cleared nor swapped: they keep what they
 * had.
 */

#ifndef vtkMetabufferSynchronizedRenderers_h
#define vtkMetabufferSynchronizedRenderers_h

#include "IsosurfaceRenderingModule.h" // For export macro
#include "vtkIceTSynchronizedRenderers.h"

#include <memory> // For the implementation

class vtkMetabufferPass;

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

  /// The pass erases the window, instead of the superclass' camera pass.
  void HandleStartRender() override;
  void HandleEndRender() override;
  /// Copies the image to the window where that gives the superclass' result.
  void PushImageToScreen() override;

private:
  vtkMetabufferSynchronizedRenderers(const vtkMetabufferSynchronizedRenderers&) = delete;
  void operator=(const vtkMetabufferSynchronizedRenderers&) = delete;

  bool IsActive() const;
  /// Called when the window has shown the frame, or has skipped it because it shows no tile.
  void HandleEndOfFrame(vtkObject* window, unsigned long event, void* data);

  class Internals;
  std::unique_ptr<Internals> Internal;
};

#endif
