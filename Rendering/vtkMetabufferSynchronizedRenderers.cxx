// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMetabufferSynchronizedRenderers.h"

#include "DrawTextures.h"
#include "OpenGLFunctions.h"
#include "Ranks/Compositing/Background.h"

#include "vtkCameraPass.h"
#include "vtkCommand.h"
#include "vtkMetabufferPass.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkOpenGLFXAAFilter.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLRenderer.h"
#include "vtkOpenGLState.h"
#include "vtkTimerLog.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace isosurface
{
namespace
{

// Rows are put over the background, then copied to the window, in bands that fit in the cache.
constexpr std::int64_t PixelsOfBand = 1 << 16;

// The renderer's rectangle of its window.
PixelRectangle GetPlaceInWindow(vtkOpenGLRenderer* renderer)
{
  PixelRectangle place;
  renderer->GetTiledSizeAndOrigin(&place.Width, &place.Height, &place.X, &place.Y);
  return place;
}

bool HasPlainBackground(vtkOpenGLRenderer* renderer)
{
  return !renderer->GetGradientBackground() && !renderer->GetTexturedBackground() &&
    !renderer->Transparent() && !renderer->GetSelector();
}

// The color of a background of one color, as it is in the framebuffer.
std::uint32_t ReadBackground(vtkOpenGLRenderer* renderer, vtkOpenGLState* gl, int x, int y)
{
  gl->vtkglScissor(x, y, 1, 1);
  renderer->Clear();
  std::uint32_t background = 0;
  glReadPixels(x, y, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, &background);
  return background;
}

} // namespace

/**
 * Puts a merged image over a renderer's background. The result is bit for bit that of
 * vtkSynchronizedRenderers::vtkRawImage::PushToViewport(), which blends a textured rectangle: in
 * software that takes most of the time of a large frame. Where the background has one color and
 * nothing is translucent, this copies memory instead.
 */
class ImageDelivery
{
public:
  /**
   * `colors` are width x height pixels, row by row from the bottom up; nothing was drawn outside of
   * `covered`. False, with the renderer's pixels undefined, if copying is not possible: for gradient
   * and textured backgrounds, layers over others, another size than the renderer's, multisamples,
   * stencils, framebuffers of other than four bytes a pixel, translucent pixels, and OpenGL that
   * cannot write textures (see DrawTextures).
   */
  bool Deliver(vtkOpenGLRenderer* renderer, const std::uint32_t* colors, int width, int height,
    const PixelRectangle& covered)
  {
    auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetVTKWindow());
    const PixelRectangle place = GetPlaceInWindow(renderer);
    const DrawTextures textures;
    if (!window || place.Width != width || place.Height != height ||
      !HasPlainBackground(renderer) || !textures.HavePlainColors())
    {
      return false;
    }
    vtkOpenGLState* gl = window->GetState();
    const vtkOpenGLState::ScopedglScissor keepScissor(gl);
    const vtkOpenGLState::ScopedglEnableDisable keepTest(gl, GL_SCISSOR_TEST);
    gl->vtkglEnable(GL_SCISSOR_TEST);
    const std::uint32_t background = ReadBackground(renderer, gl, place.X, place.Y);
    gl->vtkglViewport(place.X, place.Y, width, height);

    const auto inWindow = [&place](const PixelRectangle& rectangle)
    {
      return PixelRectangle{ rectangle.X + place.X, rectangle.Y + place.Y, rectangle.Width,
        rectangle.Height };
    };
    const PixelRectangle whole{ 0, 0, width, height };
    const PixelRectangle inside = covered.Intersect(whole);
    const int rows =
      static_cast<int>(std::max<std::int64_t>(1, PixelsOfBand / std::max(1, inside.Width)));
    for (int y = inside.Y; y < inside.GetTop(); y += rows)
    {
      const PixelRectangle band =
        PixelRectangle{ inside.X, y, inside.Width, rows }.Intersect(inside);
      if (!PutOverBackground(colors, width, band, background, this->Band))
      {
        return false;
      }
      textures.PutColors(inWindow(band), this->Band.data());
    }
    for (const PixelRectangle& outside : { PixelRectangle::FromEdges(0, 0, width, inside.Y),
           PixelRectangle::FromEdges(0, inside.GetTop(), width, height),
           PixelRectangle::FromEdges(0, inside.Y, inside.X, inside.GetTop()),
           PixelRectangle::FromEdges(inside.GetRight(), inside.Y, width, inside.GetTop()) })
    {
      textures.ClearColors(inWindow(outside), background);
    }
    if (!renderer->GetPreserveDepthBuffer())
    {
      textures.ClearDepths(inWindow(whole));
    }
    return true;
  }

private:
  std::vector<std::uint32_t> Band; ///< some rows, put over the background
};

} // namespace isosurface

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
