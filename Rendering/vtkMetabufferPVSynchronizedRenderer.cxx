// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMetabufferPVSynchronizedRenderer.h"

#include "vtkIceTSynchronizedRenderers.h"
#include "vtkMetabufferPass.h"
#include "vtkMetabufferSynchronizedRenderers.h"
#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkMetabufferPVSynchronizedRenderer);

namespace
{

// Copies the settings that vtkPVSynchronizedRenderer made.
void CopySettings(
  vtkIceTSynchronizedRenderers* stock, vtkMetabufferSynchronizedRenderers* renderers)
{
  const int* dimensions = stock->GetIceTCompositePass()->GetTileDimensions();
  const int* mullions = stock->GetIceTCompositePass()->GetTileMullions();
  renderers->SetTileDimensions(dimensions[0], dimensions[1]);
  renderers->SetTileMullions(mullions[0], mullions[1]);
  renderers->SetFixBackground(stock->GetFixBackground());
  renderers->SetParallelController(stock->GetParallelController());
  renderers->SetRootProcessId(stock->GetRootProcessId());
  renderers->SetWriteBackImages(stock->GetWriteBackImages());
  renderers->SetAutomaticEventHandling(stock->GetAutomaticEventHandling());
}

} // namespace

vtkMetabufferPVSynchronizedRenderer::vtkMetabufferPVSynchronizedRenderer() = default;
vtkMetabufferPVSynchronizedRenderer::~vtkMetabufferPVSynchronizedRenderer() = default;

void vtkMetabufferPVSynchronizedRenderer::InitializeMetabuffer(vtkPVSession* session)
{
  this->Initialize(session);
  auto* stock = vtkIceTSynchronizedRenderers::SafeDownCast(this->ParallelSynchronizer);
  if (!stock)
  {
    return;
  }
  auto* renderers = vtkMetabufferSynchronizedRenderers::New();
  CopySettings(stock, renderers);
  // Depths are collected only on request; see vtkMetabufferRenderView::CaptureZBuffer().
  renderers->GetMetabufferPass()->CollectDepthsOff();
  stock->Delete();
  this->ParallelSynchronizer = renderers;
  if (this->CSSynchronizer)
  {
    this->CSSynchronizer->SetCaptureDelegate(renderers);
  }
}

vtkMetabufferPass* vtkMetabufferPVSynchronizedRenderer::GetMetabufferPass()
{
  auto* renderers = vtkMetabufferSynchronizedRenderers::SafeDownCast(this->ParallelSynchronizer);
  return renderers ? renderers->GetMetabufferPass() : nullptr;
}

void vtkMetabufferPVSynchronizedRenderer::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
