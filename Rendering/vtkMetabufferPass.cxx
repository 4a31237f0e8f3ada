// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMetabufferPass.h"

#include "ControllerCommunicator.h"
#include "DepthSharing.h"
#include "Ground/Base/Fingerprint.h"
#include "IceTCompositor.h"
#include "Ranks/Compositing/FramePlanner.h"
#include "Ranks/Compositing/ImageScaling.h"
#include "Ranks/Compositing/ViewportCompositor.h"
#include "Ranks/Compositing/ViewportOutlines.h"
#include "SceneProjection.h"
#include "ViewportDrawing.h"

#include "vtkFloatArray.h"
#include "vtkIceTContext.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkOpenGLError.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLState.h"
#include "vtkRenderState.h"
#include "vtkRenderer.h"
#include "vtkTimerLog.h"
#include "vtkUnsignedCharArray.h"

#include <IceT.h>

#include <algorithm>
#include <vector>

using isosurface::DisplayTile;
using isosurface::ImageView;
using isosurface::PixelRectangle;
using isosurface::Status;
using isosurface::Viewport;

namespace
{

constexpr int MaximumDisplay = isosurface::ViewportDrawing::MaximumDisplay;

// Samples for a pixel with antialiasing, in each direction.
constexpr int SamplesOfAntiAliasing = 2;

std::uint32_t* GetColors(vtkSynchronizedRenderers::vtkRawImage& image)
{
  return reinterpret_cast<std::uint32_t*>(image.GetRawPtr()->GetPointer(0));
}

int GetLength(const isosurface::DisplayLayout& display)
{
  const PixelRectangle extent = display.GetExtent();
  return std::max(extent.Width, extent.Height);
}

std::uint64_t ComputeFingerprint(const isosurface::DisplayLayout& display)
{
  isosurface::Fingerprint fingerprint;
  for (const DisplayTile& tile : display.Tiles)
  {
    for (const int number :
      { tile.Pixels.X, tile.Pixels.Y, tile.Pixels.Width, tile.Pixels.Height, tile.Rank })
    {
      fingerprint.AddNumber(static_cast<std::uint64_t>(number));
    }
  }
  return fingerprint.Get();
}

} // namespace

/// The steps of a frame, and their state between frames.
class vtkMetabufferPass::Internals
{
public:
  static int GetRank(const vtkMetabufferPass& pass) { return pass.Controller->GetLocalProcessId(); }
  /// The tile that this rank shows, or null.
  const DisplayTile* FindTile(const vtkMetabufferPass& pass) const
  {
    return pass.Controller ? this->Display.FindTile(this->GetRank(pass)) : nullptr;
  }
  const Viewport& GetViewport(const vtkMetabufferPass& pass) const
  {
    return this->Plan.Viewports[static_cast<std::size_t>(this->GetRank(pass))];
  }

  bool UsesDirectSend(const vtkMetabufferPass& pass) const
  {
    return pass.CompositeMode == DIRECT_SEND || this->Display.SamplesPerPixel > 1;
  }

  /// Whether all ranks can use viewports. Collective, unless there is no controller.
  static bool IsPossibleOnAll(const vtkMetabufferPass& pass, bool isPossible);
  /// Whether all ranks are ready to draw, with the display and the settings that decide who sends
  /// what.
  Status AgreeToDraw(const vtkMetabufferPass& pass, bool isReady) const;
  /// Agrees on the viewports of all ranks.
  void PlanFrame(const vtkMetabufferPass& pass, const vtkRenderState* state);
  /// Draws this rank's viewport, reads it back, and upsamples it if the pass does. An error of one
  /// rank is one of all.
  Status Draw(const vtkMetabufferPass& pass, const vtkRenderState* state, ImageView& image);
  /// Brings the image to full resolution if SmoothUpsampling asks for it.
  void Upsample(const vtkMetabufferPass& pass, ImageView& image);
  /// Takes the memory that merging needs on this rank.
  void PrepareMerge(const vtkMetabufferPass& pass);
  /// Merges the images of all ranks into the pass' last rendered image. An error of one rank is one
  /// of all.
  Status Merge(vtkMetabufferPass& pass, const ImageView& image);
  /// Draws over the image of this rank's tile.
  void DrawOutlines(vtkMetabufferPass& pass) const;

  isosurface::ViewportDrawing Drawing;
  isosurface::FramePlanner Planner;
  std::vector<int> Divisors;
  bool UsedViewports = false;
  bool ToldOfStock = false; ///< whether it was logged that the superclass renders
  double LastSeconds = 0;   ///< of the last frame
  double ReadSeconds = 0;
  vtkTypeInt64 DrawnPixels = 0;
  vtkTypeInt64 BytesSent = 0;
  isosurface::DisplayLayout Display;
  isosurface::FramePlan Plan; ///< of the last frame

private:
  Status MergeByDirectSend(
    vtkMetabufferPass& pass, const std::vector<Viewport>& viewports, const ImageView& image);

  isosurface::DepthSharing Sharing;
  isosurface::ViewportCompositor DirectSend;
  isosurface::IceTCompositor IceT;
  isosurface::ImageBuffer Smooth; ///< this rank's image, upsampled
};

bool vtkMetabufferPass::Internals::IsPossibleOnAll(const vtkMetabufferPass& pass, bool isPossible)
{
  return isosurface::ControllerCommunicator(pass.Controller).All(isPossible);
}

Status vtkMetabufferPass::Internals::AgreeToDraw(const vtkMetabufferPass& pass, bool isReady) const
{
  const Status mine = isReady
    ? Status::Ok()
    : Status(isosurface::StatusCode::IoError, "Could not initialize IceT context.");
  const auto flag = [](bool isSet) { return std::uint64_t{ isSet ? 1U : 0U }; };
  return isosurface::ControllerCommunicator(pass.Controller)
    .Agree(mine,
      { { static_cast<std::uint64_t>(pass.CompositeMode),
          "the ranks of the view have different composite modes" },
        { flag(pass.SmoothUpsampling), "some ranks of the view upsample smoothly, some do not" },
        { flag(pass.AntiAliasing != 0), "some ranks of the view antialias, some do not" },
        { ComputeFingerprint(this->Display), "the ranks of the view have different displays" } });
}

void vtkMetabufferPass::Internals::PlanFrame(
  const vtkMetabufferPass& pass, const vtkRenderState* state)
{
  std::vector<int> divisors = { pass.GetDivisor(this->GetRank(pass)) };
  if (pass.FrameTimeBudget > 0)
  {
    divisors.clear();
    for (std::size_t resolution = 0; resolution < isosurface::NumberOfResolutions; ++resolution)
    {
      divisors.push_back(isosurface::GetResolutionDivisor(resolution));
    }
  }
  const PixelRectangle extent = this->Display.GetExtent();
  isosurface::FrameProposal mine =
    isosurface::MakeProposal(state, extent, divisors, pass.ViewportMode == FULL_DISPLAY);
  mine.LastSeconds = this->LastSeconds;
  mine.Budget = pass.FrameTimeBudget;
  mine.WantsDepths = pass.CollectDepths || pass.DisplayDepthResults;
  const bool hasOthers = pass.Controller->GetNumberOfProcesses() > 1;
  this->Sharing.Begin(state, extent, pass.ShareDepths && hasOthers, mine);
  isosurface::ControllerCommunicator communicator(pass.Controller);
  this->Plan = this->Planner.Plan(communicator, mine, extent);
}

Status vtkMetabufferPass::Internals::Draw(
  const vtkMetabufferPass& pass, const vtkRenderState* state, ImageView& image)
{
  const Viewport& viewport = this->GetViewport(pass);
  this->DrawnPixels = viewport.Blocks.GetArea();
  isosurface::ControllerCommunicator communicator(pass.Controller);
  const auto draw = [&]
  { return this->Drawing.Draw(state, pass.RenderPass, this->Display.GetExtent(), viewport); };
  Status drawn = this->Sharing.Draw(communicator, this->Plan, draw);
  if (drawn.IsOk())
  {
    const double begin = vtkTimerLog::GetUniversalTime();
    image = this->Drawing.Read(state, viewport);
    this->ReadSeconds = vtkTimerLog::GetUniversalTime() - begin;
    drawn = isosurface::Attempt("an image cannot be merged",
      [&]
      {
        this->Upsample(pass, image);
        this->PrepareMerge(pass);
        return Status::Ok();
      });
  }
  return communicator.Agree(drawn);
}

void vtkMetabufferPass::Internals::Upsample(const vtkMetabufferPass& pass, ImageView& image)
{
  const Viewport& drawn = this->GetViewport(pass);
  if (pass.SmoothUpsampling && drawn.Divisor > 1 && !drawn.Blocks.IsEmpty())
  {
    isosurface::UpsampleSmoothly(
      image, drawn.Divisor, drawn.GetPixels(this->Display.GetExtent()), this->Smooth);
    image = this->Smooth.GetView();
  }
}

void vtkMetabufferPass::Internals::PrepareMerge(const vtkMetabufferPass& pass)
{
  if (!this->UsesDirectSend(pass))
  {
    this->IceT.Prepare(this->Display);
  }
  if (const DisplayTile* tile = this->FindTile(pass))
  {
    const PixelRectangle pixels = this->Display.CoverWithPixels(tile->Pixels);
    pass.LastRenderedRGBAColors->Resize(pixels.Width, pixels.Height, 4);
    if (this->Plan.WantsDepths)
    {
      pass.LastRenderedDepths->SetNumberOfTuples(pixels.GetArea());
    }
  }
}

Status vtkMetabufferPass::Internals::Merge(vtkMetabufferPass& pass, const ImageView& image)
{
  std::vector<Viewport> viewports = this->Plan.Viewports;
  if (pass.SmoothUpsampling)
  {
    const PixelRectangle extent = this->Display.GetExtent();
    for (Viewport& viewport : viewports)
    {
      viewport = isosurface::MakeViewport(viewport.GetPixels(extent), 1);
    }
  }
  if (this->UsesDirectSend(pass))
  {
    return this->MergeByDirectSend(pass, viewports, image);
  }
  this->IceT.Composite(this->Display, viewports[static_cast<std::size_t>(this->GetRank(pass))],
    image, this->Plan.WantsDepths, *pass.LastRenderedRGBAColors, pass.LastRenderedDepths);
  this->BytesSent = this->IceT.GetBytesSent();
  return Status::Ok();
}

Status vtkMetabufferPass::Internals::MergeByDirectSend(
  vtkMetabufferPass& pass, const std::vector<Viewport>& viewports, const ImageView& image)
{
  const DisplayTile* tile = this->FindTile(pass);
  isosurface::TileImage shown;
  if (tile)
  {
    shown.Colors = GetColors(*pass.LastRenderedRGBAColors);
    if (this->Plan.WantsDepths)
    {
      shown.Depths = pass.LastRenderedDepths->GetPointer(0);
    }
  }
  isosurface::ControllerCommunicator communicator(pass.Controller);
  ISOSURFACE_RETURN_IF_ERROR(this->DirectSend.Composite(
    communicator, this->Display, viewports, image, shown, this->Plan.WantsDepths));
  if (tile)
  {
    pass.LastRenderedRGBAColors->MarkValid();
  }
  this->BytesSent = static_cast<vtkTypeInt64>(this->DirectSend.GetBytesSent());
  return Status::Ok();
}

void vtkMetabufferPass::Internals::DrawOutlines(vtkMetabufferPass& pass) const
{
  if (const DisplayTile* tile = this->FindTile(pass))
  {
    isosurface::DrawViewportOutlines(
      this->Plan.Viewports, this->Display, *tile, GetColors(*pass.LastRenderedRGBAColors));
  }
}

vtkStandardNewMacro(vtkMetabufferPass);

vtkMetabufferPass::vtkMetabufferPass()
  : Internal(new Internals)
{
}

vtkMetabufferPass::~vtkMetabufferPass() = default;

void vtkMetabufferPass::ReleaseGraphicsResources(vtkWindow* window)
{
  this->Internal->Drawing.ReleaseGraphicsResources(window);
  this->Superclass::ReleaseGraphicsResources(window);
}

bool vtkMetabufferPass::CanUseViewports(const vtkRenderState* state)
{
  const bool isOrdered = this->OrderedCompositingHelper && this->UseOrderedCompositing;
  if (isOrdered && !this->Internal->ToldOfStock && this->Controller &&
    this->Controller->GetLocalProcessId() == 0)
  {
    this->Internal->ToldOfStock = true;
    vtkLogF(INFO,
      "Viewports are not used where translucent geometry or volumes are composited in order.");
  }
  return this->Controller && !isOrdered && !this->EnableFloatValuePass &&
    !this->DataReplicatedOnAllProcesses && this->ImageReductionFactor <= 1 &&
    !this->RenderEmptyImages && !state->GetFrameBuffer() && !state->GetRenderer()->GetSelector() &&
    !state->GetRenderer()->GetUseSSAO();
}

void vtkMetabufferPass::Render(const vtkRenderState* state)
{
  Internals& internal = *this->Internal;
  const double begin = vtkTimerLog::GetUniversalTime();
  internal.Plan = {};
  internal.ReadSeconds = 0;
  internal.DrawnPixels = 0;
  internal.BytesSent = 0;
  internal.UsedViewports = internal.IsPossibleOnAll(*this, this->CanUseViewports(state));
  if (internal.UsedViewports)
  {
    const Status status = this->RenderViewports(state);
    if (!status.IsOk())
    {
      this->FailFrame(state, status);
    }
  }
  if (internal.UsedViewports)
  {
    internal.LastSeconds = vtkTimerLog::GetUniversalTime() - begin;
    return;
  }
  internal.Planner.ForgetLastFrame();
  if (this->ErasesDisplay)
  {
    state->GetRenderer()->Clear();
  }
  this->Superclass::Render(state);
}

Status vtkMetabufferPass::RenderViewports(const vtkRenderState* state)
{
  Internals& internal = *this->Internal;
  vtkOpenGLState* gl =
    static_cast<vtkOpenGLRenderWindow*>(state->GetRenderer()->GetRenderWindow())->GetState();
  const vtkOpenGLState::ScopedglViewport keepViewport(gl);
  const vtkOpenGLState::ScopedglScissor keepScissor(gl);
  const vtkOpenGLState::ScopedglEnableDisable keepTest(gl, GL_SCISSOR_TEST);
  this->IceTContext->SetController(this->Controller);
  const bool isReady = this->IceTContext->IsValid() != 0;
  if (isReady)
  {
    this->IceTContext->MakeCurrent();
    this->SetUpDisplay(state);
  }
  ISOSURFACE_RETURN_IF_ERROR(internal.AgreeToDraw(*this, isReady));
  internal.UsedViewports = GetLength(internal.Display) <= MaximumDisplay;
  if (internal.UsedViewports && !internal.Display.GetExtent().IsEmpty())
  {
    return this->DrawFrame(state);
  }
  return Status::Ok();
}

void vtkMetabufferPass::SetUpDisplay(const vtkRenderState* state)
{
  // Tiles, formats and strategy as in the superclass. A scissor keeps it from clearing the window,
  // and IceT gets no bounds, by which it would cut the viewport.
  vtkOpenGLState* gl =
    static_cast<vtkOpenGLRenderWindow*>(state->GetRenderer()->GetRenderWindow())->GetState();
  gl->vtkglEnable(GL_SCISSOR_TEST);
  gl->vtkglScissor(0, 0, 1, 1);
  this->SetupContext(state);
  icetBoundingVertices(0, ICET_DOUBLE, 0, 0, nullptr);
  this->LastRenderedRGBAColors->MarkInValid();
  this->LastRenderedDepths->SetNumberOfComponents(1);
  this->LastRenderedDepths->SetNumberOfTuples(0);

  isosurface::DisplayLayout& display = this->Internal->Display;
  display = isosurface::GetIceTDisplay();
  if (this->AntiAliasing && GetLength(display) <= MaximumDisplay / SamplesOfAntiAliasing)
  {
    display = isosurface::MakeDisplayLayout(display.Tiles, SamplesOfAntiAliasing);
  }
}

Status vtkMetabufferPass::DrawFrame(const vtkRenderState* state)
{
  Internals& internal = *this->Internal;
  internal.PlanFrame(*this, state);
  ImageView image;
  const Status drawn = internal.Draw(*this, state, image);
  vtkOpenGLClearErrorMacro();
  ISOSURFACE_RETURN_IF_ERROR(drawn);
  ISOSURFACE_RETURN_IF_ERROR(internal.Merge(*this, image));
  if (this->ShowViewports && this->LastRenderedRGBAColors->IsValid())
  {
    internal.DrawOutlines(*this);
  }
  this->DisplayResultsIfNeeded(state);
  this->CleanupContext(state);
  return Status::Ok();
}

void vtkMetabufferPass::FailFrame(const vtkRenderState* state, const isosurface::Status& status)
{
  this->LastRenderedRGBAColors->MarkInValid();
  this->LastRenderedDepths->SetNumberOfTuples(0);
  this->Internal->Planner.ForgetLastFrame();
  if (this->ErasesDisplay)
  {
    state->GetRenderer()->Clear();
  }
  // The rank that failed reports the reason; the others have nothing to add.
  if (status.GetCode() != isosurface::StatusCode::RemoteFailure)
  {
    vtkErrorMacro(<< status.GetMessage());
  }
}

void vtkMetabufferPass::SetNumberOfDivisors(int count)
{
  const auto size = static_cast<std::size_t>(std::max(0, count));
  if (size != this->Internal->Divisors.size())
  {
    this->Internal->Divisors.resize(size, 1);
    this->Modified();
  }
}

int vtkMetabufferPass::GetNumberOfDivisors() const
{
  return static_cast<int>(this->Internal->Divisors.size());
}

void vtkMetabufferPass::SetDivisor(int index, int divisor)
{
  if (index < 0 || divisor < 1 || divisor > isosurface::MaximumDivisor)
  {
    vtkErrorMacro("The divisor " << divisor << " of rank " << index << " is not from 1 to "
                                 << isosurface::MaximumDivisor << ", or there is no such rank.");
    return;
  }
  this->SetNumberOfDivisors(std::max(index + 1, this->GetNumberOfDivisors()));
  if (this->Internal->Divisors[static_cast<std::size_t>(index)] != divisor)
  {
    this->Internal->Divisors[static_cast<std::size_t>(index)] = divisor;
    this->Modified();
  }
}

int vtkMetabufferPass::GetDivisor(int index) const
{
  const std::vector<int>& divisors = this->Internal->Divisors;
  return divisors.empty() || index < 0
    ? 1
    : divisors[std::min(static_cast<std::size_t>(index), divisors.size() - 1)];
}

void vtkMetabufferPass::SetLastFrameSeconds(double seconds)
{
  this->Internal->LastSeconds = this->Internal->UsedViewports ? seconds : 0;
}

double vtkMetabufferPass::GetReadSeconds() const
{
  return this->Internal->ReadSeconds;
}

vtkTypeInt64 vtkMetabufferPass::GetDrawnPixels() const
{
  return this->Internal->DrawnPixels;
}

vtkTypeInt64 vtkMetabufferPass::GetBytesSent() const
{
  return this->Internal->BytesSent;
}

bool vtkMetabufferPass::GetUsedViewports() const
{
  return this->Internal->UsedViewports;
}

void vtkMetabufferPass::GetViewport(int rank, int viewport[5]) const
{
  std::fill_n(viewport, 5, 0);
  const std::vector<Viewport>& viewports = this->Internal->Plan.Viewports;
  if (rank < 0 || static_cast<std::size_t>(rank) >= viewports.size())
  {
    return;
  }
  const Viewport& drawn = viewports[static_cast<std::size_t>(rank)];
  const isosurface::DisplayLayout& display = this->Internal->Display;
  const PixelRectangle pixels = display.CoverWithPixels(drawn.GetPixels(display.GetExtent()));
  if (!pixels.IsEmpty())
  {
    viewport[0] = pixels.X;
    viewport[1] = pixels.Y;
    viewport[2] = pixels.Width;
    viewport[3] = pixels.Height;
    viewport[4] = drawn.Divisor;
  }
}

bool vtkMetabufferPass::ShowsTile() const
{
  return !this->Internal->UsedViewports || this->Internal->FindTile(*this) != nullptr;
}

void vtkMetabufferPass::GetCoveredPixels(int rectangle[4]) const
{
  std::fill_n(rectangle, 4, 0);
  const DisplayTile* tile = this->Internal->FindTile(*this);
  if (!this->Internal->UsedViewports || !tile)
  {
    return;
  }
  PixelRectangle covered;
  for (const Viewport& viewport : this->Internal->Plan.Viewports)
  {
    covered = covered.Unite(viewport.GetPixels(tile->Pixels));
  }
  covered.X -= tile->Pixels.X;
  covered.Y -= tile->Pixels.Y;
  covered = this->Internal->Display.CoverWithPixels(covered);
  rectangle[0] = covered.X;
  rectangle[1] = covered.Y;
  rectangle[2] = covered.Width;
  rectangle[3] = covered.Height;
}

void vtkMetabufferPass::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ViewportMode: " << this->ViewportMode << "\n"
     << indent << "CompositeMode: " << this->CompositeMode << "\n"
     << indent << "FrameTimeBudget: " << this->FrameTimeBudget << "\n"
     << indent << "AntiAliasing: " << this->AntiAliasing << "\n"
     << indent << "SmoothUpsampling: " << this->SmoothUpsampling << "\n"
     << indent << "CollectDepths: " << this->CollectDepths << "\n"
     << indent << "ShareDepths: " << this->ShareDepths << "\n"
     << indent << "ShowViewports: " << this->ShowViewports << "\n"
     << indent << "ErasesDisplay: " << this->ErasesDisplay << "\n"
     << indent << "Divisors:";
  for (const int divisor : this->Internal->Divisors)
  {
    os << " " << divisor;
  }
  os << "\n";
}
