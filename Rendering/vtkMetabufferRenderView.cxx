// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMetabufferRenderView.h"

#include "vtkMetabufferPVSynchronizedRenderer.h"
#include "vtkMetabufferPass.h"
#include "vtkObjectFactory.h"
#include "vtkPVVersion.h"
#include "vtkRenderer.h"

#define ISOSURFACE_HAS_INDEPENDENT_VIEWERS \
  (PARAVIEW_VERSION_MAJOR > 6 || (PARAVIEW_VERSION_MAJOR == 6 && PARAVIEW_VERSION_MINOR >= 2))
#if ISOSURFACE_HAS_INDEPENDENT_VIEWERS
#  include "vtkIndependentViewerCollection.h"
#endif

#include <algorithm>

vtkStandardNewMacro(vtkMetabufferRenderView);

vtkMetabufferRenderView::vtkMetabufferRenderView()
{
  // Replaces the one that the superclass made.
  this->SynchronizedRenderers->SetRenderer(nullptr);
  this->SynchronizedRenderers->Delete();
  auto* renderers = vtkMetabufferPVSynchronizedRenderer::New();
  this->SynchronizedRenderers = renderers;
  renderers->InitializeMetabuffer(this->GetSession());
  renderers->SetRenderer(this->GetRenderer());
#if ISOSURFACE_HAS_INDEPENDENT_VIEWERS
  renderers->SetIndependentViewers(this->ViewerCollection.Get());
#endif
}

vtkMetabufferRenderView::~vtkMetabufferRenderView() = default;

vtkMetabufferPass* vtkMetabufferRenderView::GetPass()
{
  return static_cast<vtkMetabufferPVSynchronizedRenderer*>(this->SynchronizedRenderers)
    ->GetMetabufferPass();
}

void vtkMetabufferRenderView::SetViewportMode(int mode)
{
  if (vtkMetabufferPass* pass = this->GetPass())
  {
    pass->SetViewportMode(mode);
  }
}

void vtkMetabufferRenderView::SetCompositeMode(int mode)
{
  if (vtkMetabufferPass* pass = this->GetPass())
  {
    pass->SetCompositeMode(mode);
  }
}

void vtkMetabufferRenderView::SetResolutionMode(int mode)
{
  this->ResolutionMode = std::clamp<int>(mode, FULL, TIME_BUDGET);
  this->UpdateResolution();
}

void vtkMetabufferRenderView::SetNumberOfDivisors(int count)
{
  this->Divisors.resize(static_cast<std::size_t>(std::max(0, count)), 1);
  this->UpdateResolution();
}

void vtkMetabufferRenderView::SetDivisor(int index, int divisor)
{
  if (index >= 0)
  {
    this->SetNumberOfDivisors(std::max(index + 1, static_cast<int>(this->Divisors.size())));
    this->Divisors[static_cast<std::size_t>(index)] = divisor;
    this->UpdateResolution();
  }
}

void vtkMetabufferRenderView::UpdateResolution()
{
  vtkMetabufferPass* pass = this->GetPass();
  if (!pass)
  {
    return;
  }
  const bool isFull = this->ResolutionMode != PER_RANK;
  pass->SetNumberOfDivisors(isFull ? 0 : static_cast<int>(this->Divisors.size()));
  for (std::size_t index = 0; !isFull && index < this->Divisors.size(); ++index)
  {
    pass->SetDivisor(static_cast<int>(index), this->Divisors[index]);
  }
}

void vtkMetabufferRenderView::AboutToRenderOnLocalProcess(bool interactive)
{
  const bool hasBudget = interactive && this->ResolutionMode == TIME_BUDGET;
  if (vtkMetabufferPass* pass = this->GetPass())
  {
    pass->SetFrameTimeBudget(hasBudget ? this->FrameTimeBudget : 0);
    if (hasBudget && !this->GetUseOrderedCompositing() && !this->GetRenderEmptyImages() &&
      !this->GetRenderer()->GetUseSSAO())
    {
      // Viewports are used, and the stock view would lower the resolution of all ranks as well.
      this->SynchronizedRenderers->SetImageReductionFactor(1);
    }
  }
  this->Superclass::AboutToRenderOnLocalProcess(interactive);
}

void vtkMetabufferRenderView::SetAntiAliasing(bool antiAliasing)
{
  if (vtkMetabufferPass* pass = this->GetPass())
  {
    pass->SetAntiAliasing(antiAliasing);
  }
}

void vtkMetabufferRenderView::SetSmoothUpsampling(bool smoothUpsampling)
{
  if (vtkMetabufferPass* pass = this->GetPass())
  {
    pass->SetSmoothUpsampling(smoothUpsampling);
  }
}

void vtkMetabufferRenderView::SetShowViewports(bool show)
{
  if (vtkMetabufferPass* pass = this->GetPass())
  {
    pass->SetShowViewports(show);
  }
}

void vtkMetabufferRenderView::CaptureZBuffer()
{
  // Otherwise one process renders, and its depths are there.
  if (this->GetUseDistributedRenderingForRender())
  {
    vtkMetabufferPass* pass = this->GetPass();
    if (pass)
    {
      pass->CollectDepthsOn();
    }
    this->StillRender();
    if (pass)
    {
      pass->CollectDepthsOff();
    }
  }
  this->Superclass::CaptureZBuffer();
}

void vtkMetabufferRenderView::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ResolutionMode: " << this->ResolutionMode << "\n"
     << indent << "FrameTimeBudget: " << this->FrameTimeBudget << "\n"
     << indent << "Divisors:";
  for (const int divisor : this->Divisors)
  {
    os << " " << divisor;
  }
  os << "\n";
}
