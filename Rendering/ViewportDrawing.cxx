// SPDX-License-Identifier: BSD-3-Clause
#include "ViewportDrawing.h"

#include "DrawTextures.h"
#include "OpenGLFunctions.h"
#include "Ranks/Compositing/FixedDepths.h"
#include "SceneProjection.h"

#include "vtkCamera.h"
#include "vtkMatrix4x4.h"
#include "vtkOpenGLFramebufferObject.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLState.h"
#include "vtkRenderPass.h"
#include "vtkRenderState.h"
#include "vtkRenderer.h"

#include <algorithm>
#include <array>
#include <cstddef>
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

// Turns a projection to the display into one to a raster of blocks, which may exceed the display.
void ExtendToBlocks(vtkMatrix4x4* projection, const PixelRectangle& display,
  const PixelRectangle& raster, int divisor)
{
  if (raster.Width * divisor == display.Width && raster.Height * divisor == display.Height)
  {
    return; // without any rounding error
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

// Clears a rectangle of the current framebuffer to black, transparent, far away. Where possible this
// clears textures: with a scissor software renderers implement glClear() by drawing a rectangle.
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

GLint GetDepthProperty(GLenum property)
{
  GLint value = 0;
  glGetFramebufferAttachmentParameteriv(GL_READ_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, property, &value);
  return value;
}

bool HasFixedDepths()
{
  GLint framebuffer = 0;
  glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &framebuffer);
  return framebuffer != 0 && GetDepthProperty(GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE) != GL_NONE &&
    GetDepthProperty(GL_FRAMEBUFFER_ATTACHMENT_DEPTH_SIZE) == 32 &&
    GetDepthProperty(GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE) == GL_UNSIGNED_NORMALIZED;
}

// Reads depths of the current framebuffer. Software renderers copy its numbers several times as
// fast as they convert them one by one; here that is done in bands that fit in the cache.
void ReadDepths(const PixelRectangle& from, float* depths)
{
  if (!HasFixedDepths())
  {
    glReadPixels(from.X, from.Y, from.Width, from.Height, GL_DEPTH_COMPONENT, GL_FLOAT, depths);
    return;
  }
  constexpr int pixelsOfBand = 1 << 17;
  const int rows = std::max(1, pixelsOfBand / from.Width);
  for (int y = from.Y; y < from.GetTop(); y += rows)
  {
    const int height = std::min(rows, from.GetTop() - y);
    const std::size_t count =
      static_cast<std::size_t>(height) * static_cast<std::size_t>(from.Width);
    glReadPixels(from.X, y, from.Width, height, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, depths);
    ConvertFixedDepths(depths, count);
    depths += count;
  }
}

/// Sets the renderer up for drawing a viewport; restores it in the destructor.
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
    // Inactive pixels must be black and transparent; the background is added to the merged image.
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

bool ViewportDrawing::BindLargeFramebuffer(vtkOpenGLRenderWindow* window, int columns, int rows)
{
  window->GetState()->PushFramebufferBindings();
  this->IsLargeFramebufferBound = true;
  if (!this->LargeFramebuffer)
  {
    this->LargeFramebuffer = vtkSmartPointer<vtkOpenGLFramebufferObject>::New();
    this->LargeFramebuffer->SetContext(window);
    // As many bits as in the window's framebuffer, else depths would be rounded differently.
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
      "The graphics card cannot make a framebuffer of " + std::to_string(raster.Width) + " x " +
        std::to_string(raster.Height) + " pixels." };
  }
  else
  {
    try
    {
      const auto pixels = static_cast<std::size_t>(viewport.Blocks.GetArea());
      this->Colors.resize(pixels);
      this->Depths.resize(pixels);
      this->DrawRaster(state, pass, display, raster, viewport);
    }
    catch (const std::bad_alloc&)
    {
      status = { StatusCode::OutOfMemory, "There is not enough memory for drawing." };
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
  // Layers above the first one draw over what is there, unless the framebuffer is our own.
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
  glReadPixels(blocks.X, blocks.Y, blocks.Width, blocks.Height, GL_RGBA, GL_UNSIGNED_BYTE,
    this->Colors.data());
  ReadDepths(blocks, this->Depths.data());
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
