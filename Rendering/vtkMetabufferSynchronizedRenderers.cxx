// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMetabufferSynchronizedRenderers.h"

#include "PictureDelivery.h"

#include "vtkCallbackCommand.h"
#include "vtkCameraPass.h"
#include "vtkCommand.h"
#include "vtkMetabufferPass.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkOpenGLFXAAFilter.h"
#include "vtkOpenGLRenderer.h"
#include "vtkRenderWindow.h"
#include "vtkUnsignedCharArray.h"

vtkStandardNewMacro(vtkMetabufferSynchronizedRenderers);

namespace
{

void ShowFramesAgain(vtkObject* window, unsigned long, void* observer, void*)
{
  static_cast<vtkRenderWindow*>(window)->SwapBuffersOn();
  window->RemoveObserver(static_cast<vtkCommand*>(observer));
}

} // namespace

vtkMetabufferSynchronizedRenderers::vtkMetabufferSynchronizedRenderers()
  : Delivery(new isosurface::PictureDelivery)
{
  // In the place of the pass that the superclass made.
  this->IceTCompositePass->Delete();
  this->IceTCompositePass = vtkMetabufferPass::New();
  this->IceTCompositePass->SetController(this->ParallelController);
  this->CameraRenderPass->SetDelegatePass(this->IceTCompositePass);
  this->EndOfHiddenFrame->SetCallback(ShowFramesAgain);
  this->EndOfHiddenFrame->SetClientData(this->EndOfHiddenFrame);
}

vtkMetabufferSynchronizedRenderers::~vtkMetabufferSynchronizedRenderers() = default;

vtkMetabufferPass* vtkMetabufferSynchronizedRenderers::GetMetabufferPass()
{
  return static_cast<vtkMetabufferPass*>(this->IceTCompositePass);
}

void vtkMetabufferSynchronizedRenderers::HandleStartRender()
{
  // The superclass turns it off until the merged picture is there.
  this->WantsFXAA = this->Renderer && this->Renderer->GetUseFXAA();
  this->Superclass::HandleStartRender();
  this->DoesErase = this->Renderer && this->ParallelRendering && this->ParallelController &&
    this->Renderer->GetErase();
  this->GetMetabufferPass()->SetErasesDisplay(this->DoesErase);
  if (this->DoesErase)
  {
    this->Renderer->EraseOff();
  }
}

void vtkMetabufferSynchronizedRenderers::HandleEndRender()
{
  if (this->DoesErase)
  {
    this->Renderer->EraseOn();
    this->GetMetabufferPass()->SetErasesDisplay(false);
    this->DoesErase = false;
  }
  this->Superclass::HandleEndRender();
  if (this->Renderer && this->ParallelRendering && this->ParallelController &&
    this->GetMetabufferPass()->GetUsedViewports() && !this->GetMetabufferPass()->ShowsTile())
  {
    this->HideFrame();
  }
}

void vtkMetabufferSynchronizedRenderers::HideFrame()
{
  vtkRenderWindow* window = this->Renderer->GetRenderWindow();
  if (window && window->GetSwapBuffers())
  {
    window->SwapBuffersOff();
    window->AddObserver(vtkCommand::EndEvent, this->EndOfHiddenFrame);
  }
}

void vtkMetabufferSynchronizedRenderers::PushImageToScreen()
{
  const bool isOurs = this->Image.IsValid() && this->GetFixBackground() &&
    !this->ImageProcessingPass && this->GetMetabufferPass()->GetUsedViewports() &&
    this->Image.GetRawPtr()->GetNumberOfComponents() == 4;
  int covered[4];
  this->GetMetabufferPass()->GetCoveredPixels(covered);
  if (!isOurs ||
    !this->Delivery->Deliver(this->Renderer,
      reinterpret_cast<const std::uint32_t*>(this->Image.GetRawPtr()->GetPointer(0)),
      this->Image.GetWidth(), this->Image.GetHeight(),
      { covered[0], covered[1], covered[2], covered[3] }))
  {
    this->Superclass::PushImageToScreen();
    return;
  }
  if (this->WantsFXAA)
  {
    this->Antialiasing->UpdateConfiguration(this->Renderer->GetFXAAOptions());
    this->Antialiasing->Execute(this->Renderer);
  }
}

void vtkMetabufferSynchronizedRenderers::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "MetabufferPass:\n";
  this->GetMetabufferPass()->PrintSelf(os, indent.GetNextIndent());
}
