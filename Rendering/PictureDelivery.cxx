// SPDX-License-Identifier: BSD-3-Clause
#include "PictureDelivery.h"

#include "vtkOpenGLFramebufferObject.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLRenderer.h"
#include "vtkOpenGLState.h"
#include "vtkTextureObject.h"
#include "vtk_glew.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace isosurface
{
namespace
{

// Where more of the picture than this is covered, all of it is copied: that is not more than to
// clear the colors before.
constexpr double LargestPart = 0.5;

// Whether the framebuffer that is drawn to has pixels as the picture has them.
bool HasPlainPixels()
{
  GLint framebuffer = 0;
  GLint target = GL_NONE;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
  glGetIntegerv(GL_DRAW_BUFFER, &target);
  if (framebuffer == 0 || target == GL_NONE)
  {
    return false;
  }
  const auto has = [target](GLenum property, GLint wanted)
  {
    GLint value = 0;
    glGetFramebufferAttachmentParameteriv(
      GL_DRAW_FRAMEBUFFER, static_cast<GLenum>(target), property, &value);
    return value == wanted;
  };
  GLint samples = 0;
  glGetIntegerv(GL_SAMPLES, &samples);
  return samples == 0 && has(GL_FRAMEBUFFER_ATTACHMENT_RED_SIZE, 8) &&
    has(GL_FRAMEBUFFER_ATTACHMENT_ALPHA_SIZE, 8) &&
    has(GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE, GL_UNSIGNED_NORMALIZED) &&
    has(GL_FRAMEBUFFER_ATTACHMENT_COLOR_ENCODING, GL_LINEAR);
}

bool IsOpaque(std::uint32_t color)
{
  std::array<std::uint8_t, 4> bytes{};
  std::memcpy(bytes.data(), &color, sizeof(color));
  return bytes[3] == 255;
}

// The color of a background of one color, as the framebuffer has it.
std::uint32_t ReadBackground(vtkOpenGLRenderer* renderer, vtkOpenGLState* gl, int x, int y)
{
  gl->vtkglScissor(x, y, 1, 1);
  renderer->Clear();
  std::uint32_t background = 0;
  glReadPixels(x, y, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, &background);
  return background;
}

} // namespace

bool PictureDelivery::PutOverBackground(
  const std::uint32_t* colors, int width, const PixelRectangle& part, std::uint32_t background)
{
  this->Pixels.resize(static_cast<std::size_t>(part.GetArea()));
  std::uint32_t* to = this->Pixels.data();
  bool isPlain = true;
  for (int y = part.Y; y < part.GetTop(); ++y)
  {
    const std::uint32_t* from =
      colors + static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + part.X;
    bool isRowPlain = true;
    for (int x = 0; x < part.Width; ++x)
    {
      const std::uint32_t color = from[x];
      const bool isOpaque = IsOpaque(color);
      isRowPlain &= isOpaque | (color == 0);
      to[x] = isOpaque ? color : background;
    }
    to += part.Width;
    isPlain = isPlain && isRowPlain;
  }
  return isPlain;
}

void PictureDelivery::Upload(vtkOpenGLRenderWindow* window, const PixelRectangle& part)
{
  // To make one, or to give it another size, binds it in the place of the window's.
  window->GetState()->PushFramebufferBindings();
  if (!this->Framebuffer || this->Framebuffer->GetContext() != window)
  {
    this->Framebuffer = vtkSmartPointer<vtkOpenGLFramebufferObject>::New();
    this->Framebuffer->SetContext(window);
    this->Framebuffer->PopulateFramebuffer(
      part.Width, part.Height, true, 1, VTK_UNSIGNED_CHAR, false, 0, 0);
  }
  // The texture has the renderer's size at most; it does not shrink with the part.
  const int* size = this->Framebuffer->GetLastSize();
  if (size[0] < part.Width || size[1] < part.Height)
  {
    this->Framebuffer->Resize(std::max(size[0], part.Width), std::max(size[1], part.Height));
  }
  window->GetState()->PopFramebufferBindings();
  vtkTextureObject* texture = this->Framebuffer->GetColorAttachmentAsTextureObject(0);
  texture->Activate();
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, part.Width, part.Height, GL_RGBA, GL_UNSIGNED_BYTE,
    this->Pixels.data());
  texture->Deactivate();
}

bool PictureDelivery::Deliver(vtkOpenGLRenderer* renderer, const std::uint32_t* colors, int width,
  int height, const PixelRectangle& covered)
{
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetVTKWindow());
  std::array<int, 2> size{};
  std::array<int, 2> origin{};
  renderer->GetTiledSizeAndOrigin(&size[0], &size[1], &origin[0], &origin[1]);
  if (!window || size[0] != width || size[1] != height || renderer->GetGradientBackground() ||
    renderer->GetTexturedBackground() || renderer->Transparent() || renderer->GetSelector() ||
    !HasPlainPixels())
  {
    return false;
  }
  const PixelRectangle whole{ 0, 0, width, height };
  const bool isWhole =
    static_cast<double>(covered.GetArea()) > LargestPart * static_cast<double>(whole.GetArea());
  const PixelRectangle part = isWhole ? whole : covered.Intersect(whole);

  vtkOpenGLState* gl = window->GetState();
  const vtkOpenGLState::ScopedglScissor keepScissor(gl);
  const vtkOpenGLState::ScopedglEnableDisable keepTest(gl, GL_SCISSOR_TEST);
  gl->vtkglEnable(GL_SCISSOR_TEST);
  if (!this->PutOverBackground(
        colors, width, part, ReadBackground(renderer, gl, origin[0], origin[1])))
  {
    return false;
  }

  gl->vtkglViewport(origin[0], origin[1], width, height);
  gl->vtkglScissor(origin[0], origin[1], width, height);
  if (!isWhole)
  {
    renderer->Clear();
  }
  else if (!renderer->GetPreserveDepthBuffer())
  {
    gl->vtkglClear(GL_DEPTH_BUFFER_BIT); // with what Clear() left as depth
  }
  if (part.IsEmpty())
  {
    return true;
  }
  this->Upload(window, part);
  gl->PushReadFramebufferBinding();
  this->Framebuffer->Bind(GL_READ_FRAMEBUFFER);
  this->Framebuffer->ActivateReadBuffer(0);
  gl->vtkglBlitFramebuffer(0, 0, part.Width, part.Height, origin[0] + part.X, origin[1] + part.Y,
    origin[0] + part.GetRight(), origin[1] + part.GetTop(), GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl->PopReadFramebufferBinding();
  return true;
}

} // namespace isosurface
