// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMetabufferSynchronizedRenderers.h"

#include "ImageDelivery.h"

#include "vtkCameraPass.h"
#include "vtkCommand.h"
#include "vtkMetabufferPass.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkOpenGLFXAAFilter.h"
#include "vtkOpenGLRenderer.h"
#include "vtkRenderWindow.h"
#include "vtkTimerLog.h"
#include "vtkUnsignedCharArray.h"

class vtkMetabufferSynchronizedRenderers::Internals
{
public:
  isosurface::ImageDelivery Delivery;
  vtkNew<vtkOpenGLFXAAFilter> Antialiasing;
  bool WantsFXAA = false;               ///< the renderer's UseFXAA before the frame
  bool DoesErase = false;               ///< the pass erases; the renderer's Erase is off meanwhile
  bool IsFrameHidden = false;           ///< SwapBuffers is off until the frame ends
  unsigned long EndOfFrameObserver = 0; ///< of the window; 0 if there is none
  double BeginOfFrame = 0;              ///< universal time in seconds
};

vtkStandardNewMacro(vtkMetabufferSynchronizedRenderers);

vtkMetabufferSynchronizedRenderers::vtkMetabufferSynchronizedRenderers()
  : Internal(new Internals)
{
  // Replaces the pass that the superclass made.
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

bool vtkMetabufferSynchronizedRenderers::IsActive() const
{
  return this->Renderer && this->ParallelRendering && this->ParallelController;
}

void vtkMetabufferSynchronizedRenderers::HandleStartRender()
{
  this->Internal->BeginOfFrame = vtkTimerLog::GetUniversalTime();
  // The superclass turns it off until the merged image is there.
  this->Internal->WantsFXAA = this->Renderer && this->Renderer->GetUseFXAA();
  this->Superclass::HandleStartRender();
  this->Internal->DoesErase = this->IsActive() && this->Renderer->GetErase();
  this->GetMetabufferPass()->SetErasesDisplay(this->Internal->DoesErase);
  if (this->Internal->DoesErase)
  {
    this->Renderer->EraseOff();
  }
}

void vtkMetabufferSynchronizedRenderers::HandleEndRender()
{
  if (this->Internal->DoesErase)
  {
    this->Renderer->EraseOn();
    this->GetMetabufferPass()->SetErasesDisplay(false);
    this->Internal->DoesErase = false;
  }
  this->Superclass::HandleEndRender();
  vtkRenderWindow* window = this->IsActive() ? this->Renderer->GetRenderWindow() : nullptr;
  if (!window || !this->GetMetabufferPass()->GetUsedViewports() ||
    this->Internal->EndOfFrameObserver != 0)
  {
    return;
  }
  this->Internal->IsFrameHidden =
    !this->GetMetabufferPass()->ShowsTile() && window->GetSwapBuffers();
  if (this->Internal->IsFrameHidden)
  {
    window->SwapBuffersOff();
  }
  this->Internal->EndOfFrameObserver = window->AddObserver(
    vtkCommand::EndEvent, this, &vtkMetabufferSynchronizedRenderers::HandleEndOfFrame);
}

void vtkMetabufferSynchronizedRenderers::HandleEndOfFrame(
  vtkObject* window, unsigned long vtkNotUsed(event), void* vtkNotUsed(data))
{
  window->RemoveObserver(this->Internal->EndOfFrameObserver);
  this->Internal->EndOfFrameObserver = 0;
  if (this->Internal->IsFrameHidden)
  {
    static_cast<vtkRenderWindow*>(window)->SwapBuffersOn();
    this->Internal->IsFrameHidden = false;
  }
  this->GetMetabufferPass()->SetLastFrameSeconds(
    vtkTimerLog::GetUniversalTime() - this->Internal->BeginOfFrame);
}

void vtkMetabufferSynchronizedRenderers::PushImageToScreen()
{
  const bool isOurs = this->Image.IsValid() && this->GetFixBackground() &&
    !this->ImageProcessingPass && this->GetMetabufferPass()->GetUsedViewports() &&
    this->Image.GetRawPtr()->GetNumberOfComponents() == 4;
  int covered[4];
  this->GetMetabufferPass()->GetCoveredPixels(covered);
  if (!isOurs ||
    !this->Internal->Delivery.Deliver(this->Renderer,
      reinterpret_cast<const std::uint32_t*>(this->Image.GetRawPtr()->GetPointer(0)),
      this->Image.GetWidth(), this->Image.GetHeight(),
      { covered[0], covered[1], covered[2], covered[3] }))
  {
    this->Superclass::PushImageToScreen();
    return;
  }
  if (this->Internal->WantsFXAA)
  {
    this->Internal->Antialiasing->UpdateConfiguration(this->Renderer->GetFXAAOptions());
    this->Internal->Antialiasing->Execute(this->Renderer);
  }
}

void vtkMetabufferSynchronizedRenderers::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "MetabufferPass:\n";
  this->GetMetabufferPass()->PrintSelf(os, indent.GetNextIndent());
}
