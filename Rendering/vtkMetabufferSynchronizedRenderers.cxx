// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMetabufferSynchronizedRenderers.h"

#include "vtkCameraPass.h"
#include "vtkMetabufferPass.h"
#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkMetabufferSynchronizedRenderers);

vtkMetabufferSynchronizedRenderers::vtkMetabufferSynchronizedRenderers()
{
  // In the place of the pass that the superclass made.
  this->IceTCompositePass->Delete();
  this->IceTCompositePass = vtkMetabufferPass::New();
  this->IceTCompositePass->SetController(this->ParallelController);
  this->CameraRenderPass->SetDelegatePass(this->IceTCompositePass);
}

vtkMetabufferSynchronizedRenderers::~vtkMetabufferSynchronizedRenderers() = default;

vtkMetabufferPass* vtkMetabufferSynchronizedRenderers::GetMetabufferPass()
{
  return static_cast<vtkMetabufferPass*>(this->IceTCompositePass);
}

void vtkMetabufferSynchronizedRenderers::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "MetabufferPass:\n";
  this->GetMetabufferPass()->PrintSelf(os, indent.GetNextIndent());
}
