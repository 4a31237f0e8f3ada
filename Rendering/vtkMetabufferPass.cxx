// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMetabufferPass.h"

#include "Compositing/ImageScaling.h"
#include "Compositing/ViewportCompositor.h"
#include "Compositing/ViewportOutlines.h"
#include "ControllerCommunicator.h"
#include "FramePart.h"
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
#include <utility>
#include <vector>

using isosurface::DisplayTile;
using isosurface::ImageView;
using isosurface::PixelRectangle;
using isosurface::Status;
using isosurface::Viewport;

namespace
{

// The display has so many samples for a pixel, in each direction, where it is antialiased.
constexpr int SamplesOfAntiAliasing = 2;

// The tiles that IceT was told of, their places counted from the display's low left corner, in
// samples.
std::vector<DisplayTile> GetTiles(int samples)
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
    tiles.push_back({ { samples * (viewports[4 * tile] - display[0]),
                        samples * (viewports[4 * tile + 1] - display[1]),
                        samples * viewports[4 * tile + 2], samples * viewports[4 * tile + 3] },
      ranks[tile] });
  }
  return tiles;
}

// The pixels that have one of the samples.
PixelRectangle CoverWithPixels(const PixelRectangle& rectangle, int samples)
{
  return isosurface::CoverWithBlocks(rectangle, samples);
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
  Status CompositeByIceT(const ImageView& mine, bool wantsDepths,
    vtkSynchronizedRenderers::vtkRawImage& colors, vtkFloatArray* depths);
  Status CompositeByDirectSend(vtkMultiProcessController* controller, const ImageView& mine,
    bool wantsDepths, vtkSynchronizedRenderers::vtkRawImage& colors, vtkFloatArray* depths);
  ///@}

  /// Over the picture of this rank's tile.
  void DrawOutlines(
    vtkMultiProcessController* controller, vtkSynchronizedRenderers::vtkRawImage& colors) const;

  /// The tile that this rank shows, or null.
  const DisplayTile* FindTile(vtkMultiProcessController* controller) const;

  /// What this rank tells the others; see vtkMetabufferPass::FrameTimeBudget.
  isosurface::FramePart MakePart(
    const vtkRenderState* state, bool isFull, int divisor, double budget) const;

  /// The viewports of this frame, chosen of what all ranks told.
  void ChooseViewports(const std::vector<isosurface::FramePart>& parts);

  /// Makes colors go over from block to block, in all ranks' pictures.
  void EnlargeSmoothly(const Viewport& viewport, ImageView& mine);

  isosurface::ViewportDrawing Drawing;
  isosurface::ViewportCompositor Compositor;
  isosurface::ResolutionChooser Chooser;
  std::vector<int> Divisors;
  bool UsedViewports = false;
  bool ToldOfStock = false;
  FrameCost Cost{};
  double LastSeconds = 0;
  std::vector<isosurface::RankWork> LastWork;
  /// @name In samples, of which a pixel has Samples x Samples
  ///@{
  int Samples = 1;
  std::vector<DisplayTile> Tiles;
  std::vector<Viewport> Viewports;     ///< of all ranks in the last frame
  std::vector<Viewport> SentViewports; ///< as the pictures have them that are merged
  PixelRectangle Display;
  ///@}

private:
  void Enlarge(const PixelRectangle& pixels, int divisor, const ImageView& mine);

  isosurface::OwnImage Smooth;
  isosurface::OwnImage Fine; // the tile's picture, if it is antialiased
  // Of the display's size, of which IceT looks at the viewport alone.
  std::vector<std::uint32_t> EnlargedColors;
  std::vector<float> EnlargedDepths;
};

void vtkMetabufferPass::Internals::Enlarge(
  const PixelRectangle& pixels, int divisor, const ImageView& mine)
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

Status vtkMetabufferPass::Internals::CompositeByIceT(const ImageView& mine, bool wantsDepths,
  vtkSynchronizedRenderers::vtkRawImage& colors, vtkFloatArray* depths)
{
  IceTInt me = 0;
  icetGetIntegerv(ICET_RANK, &me);
  const Viewport& viewport = this->SentViewports[static_cast<std::size_t>(me)];
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
  const ImageView& mine, bool wantsDepths, vtkSynchronizedRenderers::vtkRawImage& colors,
  vtkFloatArray* depths)
{
  isosurface::ControllerCommunicator communicator(controller);
  const DisplayTile* tile = this->FindTile(controller);
  isosurface::TileImage picture;
  if (tile)
  {
    const PixelRectangle pixels = CoverWithPixels(tile->Pixels, this->Samples);
    colors.Resize(pixels.Width, pixels.Height, 4);
    picture.Colors = reinterpret_cast<std::uint32_t*>(colors.GetRawPtr()->GetPointer(0));
    if (wantsDepths)
    {
      depths->SetNumberOfTuples(pixels.GetArea());
      picture.Depths = depths->GetPointer(0);
    }
  }
  const isosurface::TileImage shown = picture;
  if (tile && this->Samples > 1)
  {
    this->Fine.Resize(tile->Pixels);
    picture.Colors = this->Fine.Colors.data();
    picture.Depths = wantsDepths ? this->Fine.Depths.data() : nullptr;
  }
  Status status = this->Compositor.Composite(
    communicator, this->SentViewports, this->Tiles, mine, picture, wantsDepths);
  if (status.IsOk() && shown.Colors)
  {
    if (this->Samples > 1)
    {
      isosurface::AverageSamples(picture.Colors, picture.Depths, colors.GetWidth(),
        colors.GetHeight(), shown.Colors, shown.Depths);
    }
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
  const DisplayTile* tile = this->FindTile(controller);
  if (!tile)
  {
    return;
  }
  std::vector<Viewport> viewports;
  for (const Viewport& viewport : this->Viewports)
  {
    viewports.push_back(isosurface::MakeViewport(
      CoverWithPixels(viewport.GetPixels(this->Display), this->Samples), viewport.Divisor));
  }
  isosurface::DrawViewportOutlines(viewports, CoverWithPixels(this->Display, this->Samples),
    CoverWithPixels(tile->Pixels, this->Samples),
    reinterpret_cast<std::uint32_t*>(colors.GetRawPtr()->GetPointer(0)));
}

isosurface::FramePart vtkMetabufferPass::Internals::MakePart(
  const vtkRenderState* state, bool isFull, int divisor, double budget) const
{
  isosurface::FramePart part;
  const std::size_t choices = budget > 0 ? isosurface::NumberOfResolutions : 1;
  for (std::size_t choice = 0; choice < choices; ++choice)
  {
    const int resolution = budget > 0 ? isosurface::GetResolutionDivisor(choice) : divisor;
    isosurface::ProjectedBounds bounds =
      isosurface::ViewportDrawing::FindBounds(state, this->Display, resolution);
    part.Choices.push_back(
      isosurface::MakeViewport(isFull ? this->Display : bounds.Pixels, resolution));
    if (choice == 0 && !bounds.Pixels.IsEmpty())
    {
      part.NearDistance = isosurface::ViewportDrawing::GetDistance(state, bounds.NearDepth);
      part.FarDistance = isosurface::ViewportDrawing::GetDistance(state, bounds.FarDepth);
    }
  }
  part.Triangles = isosurface::ViewportDrawing::CountCells(state);
  part.LastSeconds = this->LastSeconds;
  part.Budget = budget;
  return part;
}

void vtkMetabufferPass::Internals::ChooseViewports(const std::vector<isosurface::FramePart>& parts)
{
  double seconds = 0;
  bool hasChoices = true;
  for (const isosurface::FramePart& part : parts)
  {
    seconds = std::max(seconds, part.LastSeconds);
    hasChoices = hasChoices && part.Choices.size() == isosurface::NumberOfResolutions;
  }
  if (!this->LastWork.empty())
  {
    std::vector<int> divisors;
    for (const Viewport& viewport : this->Viewports)
    {
      divisors.push_back(viewport.Divisor);
    }
    this->Chooser.Learn(this->LastWork, divisors, seconds);
  }

  this->LastWork = isosurface::MakeRankWork(parts, this->Display);
  std::vector<int> divisors;
  if (hasChoices)
  {
    divisors = this->Chooser.Choose(this->LastWork, parts.front().Budget);
  }
  this->Viewports.clear();
  for (std::size_t rank = 0; rank < parts.size(); ++rank)
  {
    std::size_t choice = 0;
    while (hasChoices && parts[rank].Choices[choice].Divisor < divisors[rank])
    {
      ++choice;
    }
    this->Viewports.push_back(parts[rank].Choices[choice]);
  }
}

void vtkMetabufferPass::Internals::EnlargeSmoothly(const Viewport& viewport, ImageView& mine)
{
  this->SentViewports.clear();
  for (const Viewport& drawn : this->Viewports)
  {
    this->SentViewports.push_back(isosurface::MakeViewport(drawn.GetPixels(this->Display), 1));
  }
  if (viewport.Divisor > 1 && !viewport.Blocks.IsEmpty())
  {
    isosurface::EnlargeSmoothly(
      mine, viewport.Divisor, viewport.GetPixels(this->Display), this->Smooth);
    mine = this->Smooth.GetView();
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

void vtkMetabufferPass::SetLastFrameSeconds(double seconds)
{
  this->Internal->LastSeconds = this->Internal->UsedViewports ? seconds : 0;
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
  const PixelRectangle pixels =
    CoverWithPixels(drawn.GetPixels(this->Internal->Display), this->Internal->Samples);
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
  covered.X -= tile->Pixels.X;
  covered.Y -= tile->Pixels.Y;
  covered = CoverWithPixels(covered, this->Internal->Samples);
  rectangle[0] = covered.X;
  rectangle[1] = covered.Y;
  rectangle[2] = covered.Width;
  rectangle[3] = covered.Height;
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
    !this->RenderEmptyImages && !state->GetFrameBuffer() && !state->GetRenderer()->GetSelector();
}

void vtkMetabufferPass::Render(const vtkRenderState* state)
{
  Internals& internal = *this->Internal;
  const double begin = vtkTimerLog::GetUniversalTime();
  internal.Cost = {};
  internal.UsedViewports = this->CanUseViewports(state) && this->RenderViewport(state);
  if (internal.UsedViewports)
  {
    internal.Cost.FrameSeconds = vtkTimerLog::GetUniversalTime() - begin;
    internal.LastSeconds = internal.Cost.FrameSeconds;
    return;
  }
  internal.Cost = {};
  internal.Viewports.clear();
  internal.LastWork.clear();
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
  internal.Samples = 1;
  internal.Tiles = GetTiles(1);
  internal.Display = isosurface::GetDisplay(internal.Tiles);
  const PixelRectangle& display = internal.Display;
  this->LastRenderedRGBAColors->MarkInValid();
  this->LastRenderedDepths->SetNumberOfComponents(1);
  this->LastRenderedDepths->SetNumberOfTuples(0);
  if (display.IsEmpty())
  {
    return true;
  }
  constexpr int LargestDisplay = isosurface::ViewportDrawing::LargestDisplay;
  const int length = std::max(display.Width, display.Height);
  if (length > LargestDisplay)
  {
    return false;
  }
  if (this->AntiAliasing && length <= LargestDisplay / SamplesOfAntiAliasing)
  {
    internal.Samples = SamplesOfAntiAliasing;
    internal.Tiles = GetTiles(internal.Samples);
    internal.Display = isosurface::GetDisplay(internal.Tiles);
  }
  const bool wantsDepths = this->AgreeOnViewports(state);
  this->DrawAndMerge(state, wantsDepths);
  return true;
}

bool vtkMetabufferPass::AgreeOnViewports(const vtkRenderState* state)
{
  Internals& internal = *this->Internal;
  isosurface::FramePart mine = internal.MakePart(state, this->ViewportMode == FULL_DISPLAY,
    this->GetDivisor(this->Controller->GetLocalProcessId()), this->FrameTimeBudget);
  mine.WantsDepths = this->CollectDepths || this->DisplayDepthResults;

  isosurface::ControllerCommunicator communicator(this->Controller);
  std::vector<isosurface::FramePart> parts;
  bool wantsDepths = false;
  for (const isosurface::Message& message : communicator.AllGather(mine.Pack()))
  {
    parts.push_back(isosurface::FramePart::Unpack(message));
    wantsDepths = wantsDepths || parts.back().WantsDepths;
  }
  internal.ChooseViewports(parts);
  return wantsDepths;
}

void vtkMetabufferPass::DrawAndMerge(const vtkRenderState* state, bool wantsDepths)
{
  Internals& internal = *this->Internal;
  const Viewport& viewport =
    internal.Viewports[static_cast<std::size_t>(this->Controller->GetLocalProcessId())];
  internal.Cost.DisplayPixels =
    CoverWithPixels(viewport.GetPixels(internal.Display), internal.Samples).GetArea();
  internal.Cost.DrawnPixels = viewport.Blocks.GetArea();

  StepTimer timer(this->Controller, this->MeasureSteps);
  isosurface::ControllerCommunicator communicator(this->Controller);
  const Status drawn = internal.Drawing.Draw(state, this->RenderPass, internal.Display, viewport);
  internal.Cost.RenderSeconds = timer.EndStep();
  ImageView picture;
  if (drawn.IsOk())
  {
    picture = internal.Drawing.Read(state, viewport);
  }
  internal.Cost.ReadSeconds = timer.EndStep();
  vtkOpenGLClearErrorMacro();
  Status status = communicator.Agree(drawn);
  if (status.IsOk())
  {
    internal.SentViewports = internal.Viewports;
    if (this->SmoothEnlarging)
    {
      internal.EnlargeSmoothly(viewport, picture);
    }
    status = this->CompositeMode == ICET && internal.Samples == 1
      ? internal.CompositeByIceT(
          picture, wantsDepths, *this->LastRenderedRGBAColors, this->LastRenderedDepths)
      : internal.CompositeByDirectSend(this->Controller, picture, wantsDepths,
          *this->LastRenderedRGBAColors, this->LastRenderedDepths);
  }
  internal.Cost.CompositeSeconds = timer.EndStep();
  if (!status.IsOk())
  {
    this->LastRenderedRGBAColors->MarkInValid();
    this->LastRenderedDepths->SetNumberOfTuples(0);
    internal.LastWork.clear();
    if (this->ErasesDisplay)
    {
      state->GetRenderer()->Clear();
    }
    // The rank that failed tells why; the others have nothing to add.
    if (status.GetCode() != isosurface::StatusCode::RemoteFailure)
    {
      vtkErrorMacro(<< status.GetMessage());
    }
    return;
  }
  if (this->ShowViewports && this->LastRenderedRGBAColors->IsValid())
  {
    internal.DrawOutlines(this->Controller, *this->LastRenderedRGBAColors);
  }
  this->DisplayResultsIfNeeded(state);
  this->CleanupContext(state);
}

void vtkMetabufferPass::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ViewportMode: " << this->ViewportMode << "\n"
     << indent << "CompositeMode: " << this->CompositeMode << "\n"
     << indent << "FrameTimeBudget: " << this->FrameTimeBudget << "\n"
     << indent << "AntiAliasing: " << this->AntiAliasing << "\n"
     << indent << "SmoothEnlarging: " << this->SmoothEnlarging << "\n"
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
