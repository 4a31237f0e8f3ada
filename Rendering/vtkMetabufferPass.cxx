// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMetabufferPass.h"

#include "ControllerCommunicator.h"
#include "Viewport/ViewportCompositor.h"
#include "Viewport/ViewportOutlines.h"
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
#include "vtk_glew.h"

#include <IceT.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>
#include <vector>

using isosurface::DisplayTile;
using isosurface::PictureView;
using isosurface::PixelRectangle;
using isosurface::Status;
using isosurface::Viewport;

namespace
{

/// What a rank tells all others before they draw.
struct FramePart
{
  Viewport Drawn;
  bool WantsDepths = false;

  isosurface::Message Pack() const
  {
    const std::array<std::int32_t, 6> values = { this->Drawn.Divisor, this->Drawn.Blocks.X,
      this->Drawn.Blocks.Y, this->Drawn.Blocks.Width, this->Drawn.Blocks.Height,
      this->WantsDepths ? 1 : 0 };
    isosurface::Message bytes(sizeof(values));
    std::memcpy(bytes.data(), values.data(), sizeof(values));
    return bytes;
  }
  static FramePart Unpack(const isosurface::Message& bytes)
  {
    std::array<std::int32_t, 6> values{};
    std::memcpy(values.data(), bytes.data(), std::min(sizeof(values), bytes.size()));
    return { { values[0], { values[1], values[2], values[3], values[4] } }, values[5] != 0 };
  }
};

// The tiles that IceT was told of, their places counted from the display's low left corner.
std::vector<DisplayTile> GetTiles()
{
  IceTInt count = 0;
  icetGetIntegerv(ICET_NUM_TILES, &count);
  std::vector<IceTInt> viewports(4 * static_cast<std::size_t>(count));
  std::vector<IceTInt> ranks(static_cast<std::size_t>(count));
  if (count > 0)
  {
    icetGetIntegerv(ICET_TILE_VIEWPORTS, viewports.data());
    icetGetIntegerv(ICET_DISPLAY_NODES, ranks.data());
  }
  std::array<IceTInt, 4> display{};
  icetGetIntegerv(ICET_GLOBAL_VIEWPORT, display.data());
  std::vector<DisplayTile> tiles;
  for (std::size_t tile = 0; tile < ranks.size(); ++tile)
  {
    tiles.push_back({ { viewports[4 * tile] - display[0], viewports[4 * tile + 1] - display[1],
                        viewports[4 * tile + 2], viewports[4 * tile + 3] },
      ranks[tile] });
  }
  return tiles;
}

/// The stop watch of a frame.
class StepTimer
{
public:
  StepTimer(vtkMultiProcessController* controller, bool isExact)
    : Controller(isExact ? controller : nullptr)
    , Begin(vtkTimerLog::GetUniversalTime())
  {
  }
  /// Seconds since the last step ended.
  double EndStep()
  {
    if (this->Controller)
    {
      glFinish();
    }
    const double seconds = vtkTimerLog::GetUniversalTime() - this->Begin;
    if (this->Controller)
    {
      this->Controller->Barrier();
    }
    this->Begin = vtkTimerLog::GetUniversalTime();
    return seconds;
  }

private:
  vtkMultiProcessController* Controller;
  double Begin;
};

} // namespace

class vtkMetabufferPass::Internals
{
public:
  ///@{
  /// Makes the tile's picture of those of all ranks; on ranks without a tile nothing.
  Status CompositeByIceT(const Viewport& viewport, const PictureView& mine, bool wantsDepths,
    vtkSynchronizedRenderers::vtkRawImage& colors, vtkFloatArray* depths);
  Status CompositeByDirectSend(vtkMultiProcessController* controller, const PictureView& mine,
    bool wantsDepths, vtkSynchronizedRenderers::vtkRawImage& colors, vtkFloatArray* depths);
  ///@}

  /// Over the picture of this rank's tile.
  void DrawOutlines(
    vtkMultiProcessController* controller, vtkSynchronizedRenderers::vtkRawImage& colors) const;

  /// The tile that this rank shows, or null.
  const DisplayTile* FindTile(vtkMultiProcessController* controller) const;

  isosurface::ViewportDrawing Drawing;
  isosurface::ViewportCompositor Compositor;
  std::vector<int> Divisors;
  bool UsedViewports = false;
  bool ToldOfStock = false;
  FrameCost Cost{};
  std::vector<DisplayTile> Tiles;
  std::vector<Viewport> Viewports; ///< of all ranks in the last frame
  PixelRectangle Display;

private:
  void Enlarge(const PixelRectangle& pixels, int divisor, const PictureView& mine);

  // Of the display's size, of which IceT looks at the viewport alone.
  std::vector<std::uint32_t> EnlargedColors;
  std::vector<float> EnlargedDepths;
};

void vtkMetabufferPass::Internals::Enlarge(
  const PixelRectangle& pixels, int divisor, const PictureView& mine)
{
  this->EnlargedColors.resize(static_cast<std::size_t>(this->Display.GetArea()));
  this->EnlargedDepths.resize(static_cast<std::size_t>(this->Display.GetArea()));
  for (int y = pixels.Y; y < pixels.GetTop(); ++y)
  {
    std::size_t index =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(this->Display.Width) +
      static_cast<std::size_t>(pixels.X);
    for (int x = pixels.X; x < pixels.GetRight(); ++x, ++index)
    {
      const std::size_t sample = mine.GetIndex(x / divisor, y / divisor);
      this->EnlargedColors[index] = mine.Colors[sample];
      this->EnlargedDepths[index] = mine.Depths[sample];
    }
  }
}

Status vtkMetabufferPass::Internals::CompositeByIceT(const Viewport& viewport,
  const PictureView& mine, bool wantsDepths, vtkSynchronizedRenderers::vtkRawImage& colors,
  vtkFloatArray* depths)
{
  const PixelRectangle pixels = viewport.GetPixels(this->Display);
  this->Enlarge(pixels, viewport.Divisor, mine);
  if (wantsDepths)
  {
    icetDisable(ICET_COMPOSITE_ONE_BUFFER);
  }
  else
  {
    icetEnable(ICET_COMPOSITE_ONE_BUFFER);
  }
  std::array<IceTInt, 4> global{};
  icetGetIntegerv(ICET_GLOBAL_VIEWPORT, global.data());
  const std::array<IceTInt, 4> valid = { pixels.X + global[0], pixels.Y + global[1], pixels.Width,
    pixels.Height };
  const std::array<IceTFloat, 4> background = { 0, 0, 0, 0 };
  const IceTImage image = icetCompositeImage(this->EnlargedColors.data(),
    this->EnlargedDepths.data(), valid.data(), nullptr, nullptr, background.data());

  if (icetImageGetColorFormat(image) != ICET_IMAGE_COLOR_NONE)
  {
    colors.Resize(
      static_cast<int>(icetImageGetWidth(image)), static_cast<int>(icetImageGetHeight(image)), 4);
    icetImageCopyColorub(image, colors.GetRawPtr()->GetPointer(0), ICET_IMAGE_COLOR_RGBA_UBYTE);
    colors.MarkValid();
  }
  if (wantsDepths && icetImageGetDepthFormat(image) != ICET_IMAGE_DEPTH_NONE)
  {
    depths->SetNumberOfTuples(icetImageGetNumPixels(image));
    icetImageCopyDepthf(image, depths->GetPointer(0), ICET_IMAGE_DEPTH_FLOAT);
  }
  IceTInt bytes = 0;
  icetGetIntegerv(ICET_BYTES_SENT, &bytes);
  this->Cost.BytesSent = bytes;
  return Status::Ok();
}

Status vtkMetabufferPass::Internals::CompositeByDirectSend(vtkMultiProcessController* controller,
  const PictureView& mine, bool wantsDepths, vtkSynchronizedRenderers::vtkRawImage& colors,
  vtkFloatArray* depths)
{
  isosurface::ControllerCommunicator communicator(controller);
  const DisplayTile* tile = this->FindTile(controller);
  isosurface::TilePicture picture;
  if (tile)
  {
    colors.Resize(tile->Pixels.Width, tile->Pixels.Height, 4);
    picture.Colors = reinterpret_cast<std::uint32_t*>(colors.GetRawPtr()->GetPointer(0));
    if (wantsDepths)
    {
      depths->SetNumberOfTuples(tile->Pixels.GetArea());
      picture.Depths = depths->GetPointer(0);
    }
  }
  Status status = this->Compositor.Composite(
    communicator, this->Viewports, this->Tiles, mine, picture, wantsDepths);
  if (status.IsOk() && picture.Colors)
  {
    colors.MarkValid();
  }
  const isosurface::CompositeCost& cost = this->Compositor.GetCost();
  this->Cost.BytesSent = static_cast<long long>(cost.BytesSent);
  this->Cost.EncodeSeconds = cost.EncodeSeconds;
  this->Cost.ExchangeSeconds = cost.ExchangeSeconds;
  this->Cost.MergeSeconds = cost.MergeSeconds;
  this->Cost.DeliverSeconds = cost.DeliverSeconds;
  return status;
}

const DisplayTile* vtkMetabufferPass::Internals::FindTile(
  vtkMultiProcessController* controller) const
{
  const int me = controller ? controller->GetLocalProcessId() : 0;
  const auto tile = std::find_if(this->Tiles.begin(), this->Tiles.end(),
    [me](const DisplayTile& shown) { return shown.Rank == me; });
  return tile == this->Tiles.end() ? nullptr : &*tile;
}

void vtkMetabufferPass::Internals::DrawOutlines(
  vtkMultiProcessController* controller, vtkSynchronizedRenderers::vtkRawImage& colors) const
{
  if (const DisplayTile* tile = this->FindTile(controller))
  {
    isosurface::DrawViewportOutlines(this->Viewports, this->Display, tile->Pixels,
      reinterpret_cast<std::uint32_t*>(colors.GetRawPtr()->GetPointer(0)));
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
  if (index < 0 || divisor < 1 || divisor > isosurface::LargestDivisor)
  {
    vtkErrorMacro("Divisor " << divisor << " of rank " << index << " is not one of 1 to "
                             << isosurface::LargestDivisor << " of a rank.");
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

const vtkMetabufferPass::FrameCost& vtkMetabufferPass::GetFrameCost() const
{
  return this->Internal->Cost;
}

bool vtkMetabufferPass::GetUsedViewports() const
{
  return this->Internal->UsedViewports;
}

void vtkMetabufferPass::GetViewport(int rank, int viewport[5]) const
{
  std::fill_n(viewport, 5, 0);
  const std::vector<Viewport>& viewports = this->Internal->Viewports;
  if (rank < 0 || static_cast<std::size_t>(rank) >= viewports.size())
  {
    return;
  }
  const Viewport& drawn = viewports[static_cast<std::size_t>(rank)];
  const PixelRectangle pixels = drawn.GetPixels(this->Internal->Display);
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
  return !this->Internal->UsedViewports || this->Internal->FindTile(this->Controller) != nullptr;
}

void vtkMetabufferPass::GetCoveredPixels(int rectangle[4]) const
{
  std::fill_n(rectangle, 4, 0);
  const DisplayTile* tile = this->Internal->FindTile(this->Controller);
  if (!this->Internal->UsedViewports || !tile)
  {
    return;
  }
  PixelRectangle covered;
  for (const Viewport& viewport : this->Internal->Viewports)
  {
    covered = covered.Unite(viewport.GetPixels(tile->Pixels));
  }
  rectangle[0] = covered.X - tile->Pixels.X;
  rectangle[1] = covered.Y - tile->Pixels.Y;
  rectangle[2] = covered.Width;
  rectangle[3] = covered.Height;
}

bool vtkMetabufferPass::CanUseViewports(const vtkRenderState* state)
{
  const bool isOrdered = this->OrderedCompositingHelper && this->UseOrderedCompositing;
  if (isOrdered && !this->Internal->ToldOfStock)
  {
    this->Internal->ToldOfStock = true;
    vtkLogF(INFO,
      "Viewports are not used where translucent geometry or volumes are composited in order.");
  }
  return this->Controller && !isOrdered && !this->EnableFloatValuePass &&
    !this->DataReplicatedOnAllProcesses && this->ImageReductionFactor <= 1 &&
    !this->RenderEmptyImages && !state->GetFrameBuffer() && !state->GetRenderer()->GetSelector();
}

void vtkMetabufferPass::Render(const vtkRenderState* state)
{
  const double begin = vtkTimerLog::GetUniversalTime();
  this->Internal->Cost = {};
  this->Internal->Viewports.clear();
  this->Internal->UsedViewports = this->CanUseViewports(state) && this->RenderViewport(state);
  if (this->Internal->UsedViewports)
  {
    this->Internal->Cost.FrameSeconds = vtkTimerLog::GetUniversalTime() - begin;
    return;
  }
  this->Internal->Cost = {};
  if (this->ErasesDisplay)
  {
    state->GetRenderer()->Clear();
  }
  this->Superclass::Render(state);
}

bool vtkMetabufferPass::RenderViewport(const vtkRenderState* state)
{
  Internals& internal = *this->Internal;
  this->IceTContext->SetController(this->Controller);
  if (!this->IceTContext->IsValid())
  {
    vtkErrorMacro("Could not initialize IceT context.");
    return true;
  }
  this->IceTContext->MakeCurrent();
  vtkOpenGLState* gl =
    static_cast<vtkOpenGLRenderWindow*>(state->GetRenderer()->GetRenderWindow())->GetState();
  const vtkOpenGLState::ScopedglViewport keepViewport(gl);
  const vtkOpenGLState::ScopedglScissor keepScissor(gl);
  const vtkOpenGLState::ScopedglEnableDisable keepTest(gl, GL_SCISSOR_TEST);

  // Tiles, formats and strategy as usual; but no clearing of all of the window, nor bounds for IceT
  // to cut the viewport by.
  gl->vtkglEnable(GL_SCISSOR_TEST);
  gl->vtkglScissor(0, 0, 1, 1);
  this->SetupContext(state);
  icetBoundingVertices(0, ICET_DOUBLE, 0, 0, nullptr);
  internal.Tiles = GetTiles();
  internal.Display = isosurface::GetDisplay(internal.Tiles);
  const PixelRectangle& display = internal.Display;
  this->LastRenderedRGBAColors->MarkInValid();
  this->LastRenderedDepths->SetNumberOfComponents(1);
  this->LastRenderedDepths->SetNumberOfTuples(0);
  if (display.IsEmpty())
  {
    return true;
  }
  if (std::max(display.Width, display.Height) > isosurface::ViewportDrawing::LargestDisplay)
  {
    return false;
  }

  const bool wantsDepths = this->AgreeOnViewports(state);
  const Viewport& viewport =
    internal.Viewports[static_cast<std::size_t>(this->Controller->GetLocalProcessId())];
  internal.Cost.DisplayPixels = viewport.GetPixels(display).GetArea();
  internal.Cost.DrawnPixels = viewport.Blocks.GetArea();

  StepTimer timer(this->Controller, this->MeasureSteps);
  internal.Drawing.Draw(state, this->RenderPass, display, viewport);
  internal.Cost.RenderSeconds = timer.EndStep();
  const PictureView picture = internal.Drawing.Read(state, viewport);
  internal.Cost.ReadSeconds = timer.EndStep();
  vtkOpenGLClearErrorMacro();
  const Status status = this->CompositeMode == ICET
    ? internal.CompositeByIceT(
        viewport, picture, wantsDepths, *this->LastRenderedRGBAColors, this->LastRenderedDepths)
    : internal.CompositeByDirectSend(this->Controller, picture, wantsDepths,
        *this->LastRenderedRGBAColors, this->LastRenderedDepths);
  internal.Cost.CompositeSeconds = timer.EndStep();
  if (!status.IsOk())
  {
    this->LastRenderedRGBAColors->MarkInValid();
    this->LastRenderedDepths->SetNumberOfTuples(0);
    // The rank that failed tells why; the others have nothing to add.
    if (status.GetCode() != isosurface::StatusCode::RemoteFailure)
    {
      vtkErrorMacro(<< status.GetMessage());
    }
    return true;
  }
  if (this->ShowViewports && this->LastRenderedRGBAColors->IsValid())
  {
    internal.DrawOutlines(this->Controller, *this->LastRenderedRGBAColors);
  }
  this->DisplayResultsIfNeeded(state);
  this->CleanupContext(state);
  return true;
}

bool vtkMetabufferPass::AgreeOnViewports(const vtkRenderState* state)
{
  Internals& internal = *this->Internal;
  const int divisor = this->GetDivisor(this->Controller->GetLocalProcessId());
  const PixelRectangle pixels = this->ViewportMode == FULL_DISPLAY
    ? internal.Display
    : isosurface::ViewportDrawing::FindBounds(state, internal.Display, divisor).Pixels;
  FramePart mine;
  mine.Drawn = isosurface::MakeViewport(pixels, divisor);
  mine.WantsDepths = this->CollectDepths || this->DisplayDepthResults;

  isosurface::ControllerCommunicator communicator(this->Controller);
  bool wantsDepths = false;
  for (const isosurface::Message& message : communicator.AllGather(mine.Pack()))
  {
    const FramePart part = FramePart::Unpack(message);
    internal.Viewports.push_back(part.Drawn);
    wantsDepths = wantsDepths || part.WantsDepths;
  }
  return wantsDepths;
}

void vtkMetabufferPass::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ViewportMode: " << this->ViewportMode << "\n"
     << indent << "CompositeMode: " << this->CompositeMode << "\n"
     << indent << "CollectDepths: " << this->CollectDepths << "\n"
     << indent << "ShowViewports: " << this->ShowViewports << "\n"
     << indent << "MeasureSteps: " << this->MeasureSteps << "\n"
     << indent << "ErasesDisplay: " << this->ErasesDisplay << "\n"
     << indent << "Divisors:";
  for (const int divisor : this->Internal->Divisors)
  {
    os << " " << divisor;
  }
  os << "\n";
}
