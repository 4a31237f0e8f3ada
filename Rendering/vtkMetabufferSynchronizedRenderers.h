// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMetabufferSynchronizedRenderers
 * @brief   synchronizes renderers of several ranks, merging their pictures by a vtkMetabufferPass
 *
 * Used as vtkIceTSynchronizedRenderers, beside a vtkSynchronizedRenderWindows; the class is all
 * that an application without a ParaView session needs. Windows must not have multisamples.
 */

#ifndef vtkMetabufferSynchronizedRenderers_h
#define vtkMetabufferSynchronizedRenderers_h

#include "IsosurfaceRenderingModule.h" // For export macro
#include "vtkIceTSynchronizedRenderers.h"

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

private:
  vtkMetabufferSynchronizedRenderers(const vtkMetabufferSynchronizedRenderers&) = delete;
  void operator=(const vtkMetabufferSynchronizedRenderers&) = delete;
};

#endif
