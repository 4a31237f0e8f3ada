// SPDX-License-Identifier: BSD-3-Clause
#include "ViewportDrawing.h"

#include "DrawTextures.h"

#include "vtkActor.h"
#include "vtkBoundingBox.h"
#include "vtkCamera.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataSet.h"
#include "vtkMapper.h"
#include "vtkMatrix4x4.h"
#include "vtkOpenGLFramebufferObject.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLState.h"
#include "vtkProperty.h"
#include "vtkRenderPass.h"
#include "vtkRenderState.h"
#include "vtkRenderer.h"
#include "vtk_glew.h"

#include <algorithm>
#include <array>
#include <exception>
#include <new>

namespace isosurface
{
namespace
{

vtkOpenGLRenderWindow* GetWindow(const vtkRenderState* state)
{
  return static_cast<vtkOpenGLRenderWindow*>(state->GetRenderer()->GetRenderWindow());
}

// Grid and cube axes answer with the bounds of what they surround; labels are outside of these, at
// most as far away as the box is long.
bool IsAxes(vtkProp* prop)
{
  return prop->IsA("vtkGridAxes3DActor") || prop->IsA("vtkCubeAxesActor");
}

// Whether the bounds of a prop may be smaller than what it draws, in world units: glyphs that the
// mapper makes of points.
bool DrawsBeyondBounds(vtkProp* prop)
{
  const auto* actor = vtkActor::SafeDownCast(prop);
  auto* mapper = actor ? const_cast<vtkActor*>(actor)->GetMapper() : nullptr;
  return mapper &&
    (mapper->IsA("vtkPointGaussianMapper") || mapper->IsA("vtkOpenGLSphereMapper") ||
      mapper->IsA("vtkOpenGLStickMapper"));
}

// By how many pixels lines and points are wider than nothing, to one side.
double GetHalfWidth(vtkProp* prop)
{
  auto* actor = vtkActor::SafeDownCast(prop);
  vtkProperty* property = actor ? actor->GetProperty() : nullptr;
  return property ? 0.5 * std::max(property->GetLineWidth(), property->GetPointSize()) : 0;
}

/// What the visible props of a state draw.
struct VisibleProps
{
  vtkBoundingBox Bounds;
  double HalfWidth = 0.5;
  bool MayBeAnywhere = false;
};

VisibleProps FindVisibleProps(const vtkRenderState* state)
{
  VisibleProps visible;
  for (int index = 0; index < state->GetPropArrayCount(); ++index)
  {
    vtkProp* prop = state->GetPropArray()[index];
    if (!prop->GetVisibility())
    {
      continue;
    }
    const double* bounds = prop->GetUseBounds() ? prop->GetBounds() : nullptr;
    if (!bounds)
    {
      visible.MayBeAnywhere = true;
      continue;
    }
    vtkBoundingBox box(bounds);
    if (!box.IsValid())
    {
      continue;
    }
    if (IsAxes(prop))
    {
      box.Inflate(box.GetMaxLength());
    }
    visible.Bounds.AddBox(box);
    visible.MayBeAnywhere = visible.MayBeAnywhere || DrawsBeyondBounds(prop);
    visible.HalfWidth = std::max(visible.HalfWidth, GetHalfWidth(prop));
  }
  return visible;
}

vtkSmartPointer<vtkMatrix4x4> MakeProjection(vtkCamera* camera, const PixelRectangle& display)
{
  auto projection = vtkSmartPointer<vtkMatrix4x4>::New();
  projection->DeepCopy(camera->GetProjectionTransformMatrix(
    static_cast<double>(display.Width) / display.Height, -1, 1));
  return projection;
}

// Makes a projection to the display one to a raster of blocks, which may reach beyond the display.
void ExtendToBlocks(vtkMatrix4x4* projection, const PixelRectangle& display,
  const PixelRectangle& raster, int divisor)
{
  if (raster.Width * divisor == display.Width && raster.Height * divisor == display.Height)
  {
    return; // not even a rounding error
  }
  vtkNew<vtkMatrix4x4> extend;
  const double x = static_cast<double>(display.Width) / (raster.Width * divisor);
  const double y = static_cast<double>(display.Height) / (raster.Height * divisor);
  extend->SetElement(0, 0, x);
  extend->SetElement(0, 3, x - 1);
  extend->SetElement(1, 1, y);
  extend->SetElement(1, 3, y - 1);
  vtkMatrix4x4::Multiply4x4(extend, projection, projection);
}

// Clears a rectangle of the framebuffer that is drawn to, to black, transparent, far away. Not by
// glClear() if that can be avoided, which draws a rectangle if there is a scissor.
void ClearRectangle(vtkOpenGLState* gl, const PixelRectangle& rectangle, GLbitfield buffers)
{
  const DrawTextures textures;
  if (!textures.AreThere())
  {
    gl->vtkglScissor(rectangle.X, rectangle.Y, rectangle.Width, rectangle.Height);
    gl->vtkglClearColor(0, 0, 0, 0);
    gl->vtkglClearDepth(1.0);
    gl->vtkglClear(buffers);
    return;
  }
  if ((buffers & GL_COLOR_BUFFER_BIT) != 0)
  {
    textures.ClearColors(rectangle, 0);
  }
  if ((buffers & GL_DEPTH_BUFFER_BIT) != 0)
  {
    textures.ClearDepths(rectangle);
  }
}

/// The renderer as the pass is to see it; as it was, when this object goes.
class RendererForViewport
{
public:
  RendererForViewport(vtkRenderer* renderer, vtkMatrix4x4* projection)
    : Renderer(renderer)
    , Camera(renderer->GetActiveCamera())
    , Projection(this->Camera->GetExplicitProjectionTransformMatrix())
    , UsesProjection(this->Camera->GetUseExplicitProjectionTransformMatrix())
  {
    renderer->GetBackground(this->Background.data());
    renderer->GetViewport(this->Viewport.data());
    // Merging wants black, transparent, where nothing is; the display's background comes later.
    renderer->SetBackground(0, 0, 0);
    renderer->SetViewport(0, 0, 1, 1);
    this->Camera->SetExplicitProjectionTransformMatrix(projection);
    this->Camera->UseExplicitProjectionTransformMatrixOn();
  }
  ~RendererForViewport()
  {
    this->Camera->SetExplicitProjectionTransformMatrix(this->Projection);
    this->Camera->SetUseExplicitProjectionTransformMatrix(this->UsesProjection);
    this->Renderer->SetViewport(this->Viewport.data());
    this->Renderer->SetBackground(this->Background.data());
  }
  RendererForViewport(const RendererForViewport&) = delete;
  RendererForViewport& operator=(const RendererForViewport&) = delete;

private:
  vtkRenderer* Renderer;
  vtkCamera* Camera;
  vtkSmartPointer<vtkMatrix4x4> Projection;
  bool UsesProjection;
  std::array<double, 3> Background{};
  std::array<double, 4> Viewport{};
};

} // namespace

ViewportDrawing::ViewportDrawing() = default;
ViewportDrawing::~ViewportDrawing() = default;

ProjectedBounds ViewportDrawing::FindBounds(
  const vtkRenderState* state, const PixelRectangle& display, int divisor)
{
  const VisibleProps visible = FindVisibleProps(state);
  if (visible.MayBeAnywhere)
  {
    return { display, -1.0, 1.0 };
  }
  std::array<double, 6> bounds{ 1, -1, 1, -1, 1, -1 };
  if (visible.Bounds.IsValid())
  {
    visible.Bounds.GetBounds(bounds.data());
  }
  vtkCamera* camera = state->GetRenderer()->GetActiveCamera();
  vtkNew<vtkMatrix4x4> worldToClip;
  vtkMatrix4x4::Multiply4x4(
    MakeProjection(camera, display), camera->GetModelViewTransformMatrix(), worldToClip);
  std::array<double, 16> matrix{};
  std::copy_n(worldToClip->GetData(), 16, matrix.begin());
  return ProjectBounds(bounds, matrix, display, (visible.HalfWidth + 0.5) * divisor);
}

double ViewportDrawing::GetDistance(const vtkRenderState* state, double depth)
{
  vtkCamera* camera = state->GetRenderer()->GetActiveCamera();
  const double* range = camera->GetClippingRange();
  const double nearest = range[0];
  const double farthest = range[1];
  return camera->GetParallelProjection()
    ? nearest + 0.5 * (depth + 1) * (farthest - nearest)
    : 2 * nearest * farthest / (farthest + nearest - depth * (farthest - nearest));
}

std::int64_t ViewportDrawing::CountCells(const vtkRenderState* state)
{
  std::int64_t cells = 0;
  for (int index = 0; index < state->GetPropArrayCount(); ++index)
  {
    auto* actor = vtkActor::SafeDownCast(state->GetPropArray()[index]);
    vtkMapper* mapper = actor && actor->GetVisibility() ? actor->GetMapper() : nullptr;
    vtkDataObject* data = mapper && mapper->GetNumberOfInputConnections(0) > 0
      ? mapper->GetInputDataObject(0, 0)
      : nullptr;
    if (auto* set = vtkDataSet::SafeDownCast(data))
    {
      cells += set->GetNumberOfCells();
    }
    else if (auto* composite = vtkCompositeDataSet::SafeDownCast(data))
    {
      cells += composite->GetNumberOfCells();
    }
  }
  return cells;
}

bool ViewportDrawing::BindLargeFramebuffer(vtkOpenGLRenderWindow* window, int columns, int rows)
{
  window->GetState()->PushFramebufferBindings();
  this->IsLargeFramebufferBound = true;
  if (!this->LargeFramebuffer)
  {
    this->LargeFramebuffer = vtkSmartPointer<vtkOpenGLFramebufferObject>::New();
    this->LargeFramebuffer->SetContext(window);
    // As the window's own framebuffer: depths of other bits would be other depths.
    this->LargeFramebuffer->PopulateFramebuffer(
      columns, rows, true, 1, VTK_UNSIGNED_CHAR, true, 32, 0);
  }
  this->LargeFramebuffer->Resize(columns, rows);
  this->LargeFramebuffer->Bind();
  this->LargeFramebuffer->ActivateDrawBuffer(0);
  this->LargeFramebuffer->ActivateReadBuffer(0);
  return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

void ViewportDrawing::UnbindLargeFramebuffer(vtkOpenGLRenderWindow* window)
{
  if (this->IsLargeFramebufferBound)
  {
    window->GetState()->PopFramebufferBindings();
    this->IsLargeFramebufferBound = false;
  }
}

Status ViewportDrawing::Draw(const vtkRenderState* state, vtkRenderPass* pass,
  const PixelRectangle& display, const Viewport& viewport)
{
  if (viewport.Blocks.IsEmpty())
  {
    return Status::Ok();
  }
  vtkOpenGLRenderWindow* window = GetWindow(state);
  const PixelRectangle raster = CoverWithBlocks(display, viewport.Divisor);
  const int* windowSize = window->GetActualSize();
  Status status;
  if ((raster.Width > windowSize[0] || raster.Height > windowSize[1]) &&
    !this->BindLargeFramebuffer(window, raster.Width, raster.Height))
  {
    status = { StatusCode::OutOfMemory,
      "The graphics card gives no framebuffer of " + std::to_string(raster.Width) + " x " +
        std::to_string(raster.Height) + " pixels." };
  }
  else
  {
    try
    {
      this->DrawRaster(state, pass, display, raster, viewport);
    }
    catch (const std::bad_alloc&)
    {
      status = { StatusCode::OutOfMemory, "Drawing needs more memory than there is." };
    }
    catch (const std::exception& error)
    {
      status = { StatusCode::InvalidArgument, std::string("Drawing failed: ") + error.what() };
    }
  }
  if (!status.IsOk())
  {
    this->UnbindLargeFramebuffer(window);
  }
  return status;
}

void ViewportDrawing::DrawRaster(const vtkRenderState* state, vtkRenderPass* pass,
  const PixelRectangle& display, const PixelRectangle& raster, const Viewport& viewport)
{
  vtkRenderer* renderer = state->GetRenderer();
  auto projection = MakeProjection(renderer->GetActiveCamera(), display);
  ExtendToBlocks(projection, display, raster, viewport.Divisor);
  const RendererForViewport forViewport(renderer, projection);

  vtkOpenGLState* gl = GetWindow(state)->GetState();
  const PixelRectangle& blocks = viewport.Blocks;
  gl->vtkglEnable(GL_SCISSOR_TEST);
  gl->vtkglViewport(0, 0, raster.Width, raster.Height);
  // Layers above the first one draw on what is there; it is not in a framebuffer of our own.
  GLbitfield cleared = 0;
  cleared |= renderer->Transparent() && !this->IsLargeFramebufferBound ? 0 : GL_COLOR_BUFFER_BIT;
  cleared |=
    renderer->GetPreserveDepthBuffer() && !this->IsLargeFramebufferBound ? 0 : GL_DEPTH_BUFFER_BIT;
  ClearRectangle(gl, blocks, cleared);
  gl->vtkglScissor(blocks.X, blocks.Y, blocks.Width, blocks.Height);
  // As vtkRenderer::Clear() leaves it.
  gl->vtkglColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl->vtkglDepthMask(GL_TRUE);
  gl->vtkglEnable(GL_DEPTH_TEST);
  pass->Render(state);
}

ImageView ViewportDrawing::Read(const vtkRenderState* state, const Viewport& viewport)
{
  const PixelRectangle& blocks = viewport.Blocks;
  if (blocks.IsEmpty())
  {
    return {};
  }
  this->Colors.resize(static_cast<std::size_t>(blocks.GetArea()));
  this->Depths.resize(static_cast<std::size_t>(blocks.GetArea()));
  glReadPixels(blocks.X, blocks.Y, blocks.Width, blocks.Height, GL_RGBA, GL_UNSIGNED_BYTE,
    this->Colors.data());
  glReadPixels(blocks.X, blocks.Y, blocks.Width, blocks.Height, GL_DEPTH_COMPONENT, GL_FLOAT,
    this->Depths.data());
  this->UnbindLargeFramebuffer(GetWindow(state));
  return { this->Colors.data(), this->Depths.data(), blocks };
}

void ViewportDrawing::ReleaseGraphicsResources(vtkWindow* window)
{
  if (this->LargeFramebuffer)
  {
    this->LargeFramebuffer->ReleaseGraphicsResources(window);
    this->LargeFramebuffer = nullptr;
  }
}

} // namespace isosurface
