// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMetabufferPVSynchronizedRenderer
 * @brief   ParaView's synchronized renderer with a vtkMetabufferSynchronizedRenderers inside
 *
 * Where several ranks render together (pvbatch, pvserver), this replaces the synchronizer that
 * ParaView makes for them by one with the same tiles, background and roles. Clients, CAVEs and single
 * ranks are left as they are.
 */

#ifndef vtkMetabufferPVSynchronizedRenderer_h
#define vtkMetabufferPVSynchronizedRenderer_h

#include "IsosurfaceRenderingModule.h" // For export macro
#include "vtkPVSynchronizedRenderer.h"

class vtkMetabufferPass;

class ISOSURFACERENDERING_EXPORT vtkMetabufferPVSynchronizedRenderer
  : public vtkPVSynchronizedRenderer
{
public:
  static vtkMetabufferPVSynchronizedRenderer* New();
  vtkTypeMacro(vtkMetabufferPVSynchronizedRenderer, vtkPVSynchronizedRenderer);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Called instead of the superclass' Initialize(), which is not virtual.
  void InitializeMetabuffer(vtkPVSession* session);

  /// The pass that merges the images; null where no ranks render together.
  vtkMetabufferPass* GetMetabufferPass();

protected:
  vtkMetabufferPVSynchronizedRenderer();
  ~vtkMetabufferPVSynchronizedRenderer() override;

private:
  vtkMetabufferPVSynchronizedRenderer(const vtkMetabufferPVSynchronizedRenderer&) = delete;
  void operator=(const vtkMetabufferPVSynchronizedRenderer&) = delete;
};

#endif
