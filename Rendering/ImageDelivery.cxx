// SPDX-License-Identifier: BSD-3-Clause
#include "ImageDelivery.h"

#include "DrawTextures.h"

#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLRenderer.h"
#include "vtkOpenGLState.h"
#include "vtk_glew.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace isosurface
{
namespace
{

// Rows are put over the background, and then into the window, in bands that a processor keeps in
// its cache.
constexpr std::int64_t PixelsOfBand = 1 << 16;

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

bool ImageDelivery::PutOverBackground(
  const std::uint32_t* colors, int width, const PixelRectangle& band, std::uint32_t background)
{
  this->Band.resize(static_cast<std::size_t>(band.GetArea()));
  std::uint32_t* to = this->Band.data();
  bool isPlain = true;
  for (int y = band.Y; y < band.GetTop(); ++y)
  {
    const std::uint32_t* from =
      colors + static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + band.X;
    bool isRowPlain = true;
    for (int x = 0; x < band.Width; ++x)
    {
      const std::uint32_t color = from[x];
      const bool isOpaque = IsOpaque(color);
      isRowPlain &= isOpaque | (color == 0);
      to[x] = isOpaque ? color : background;
    }
    to += band.Width;
    isPlain = isPlain && isRowPlain;
  }
  return isPlain;
}

bool ImageDelivery::Deliver(vtkOpenGLRenderer* renderer, const std::uint32_t* colors, int width,
  int height, const PixelRectangle& covered)
{
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetVTKWindow());
  std::array<int, 2> size{};
  std::array<int, 2> origin{};
  renderer->GetTiledSizeAndOrigin(&size[0], &size[1], &origin[0], &origin[1]);
  const DrawTextures textures;
  if (!window || size[0] != width || size[1] != height || renderer->GetGradientBackground() ||
    renderer->GetTexturedBackground() || renderer->Transparent() || renderer->GetSelector() ||
    !textures.HavePlainColors())
  {
    return false;
  }
  vtkOpenGLState* gl = window->GetState();
  const vtkOpenGLState::ScopedglScissor keepScissor(gl);
  const vtkOpenGLState::ScopedglEnableDisable keepTest(gl, GL_SCISSOR_TEST);
  gl->vtkglEnable(GL_SCISSOR_TEST);
  const std::uint32_t background = ReadBackground(renderer, gl, origin[0], origin[1]);
  gl->vtkglViewport(origin[0], origin[1], width, height);

  const auto inWindow = [&origin](const PixelRectangle& rectangle)
  {
    return PixelRectangle{ rectangle.X + origin[0], rectangle.Y + origin[1], rectangle.Width,
      rectangle.Height };
  };
  const PixelRectangle whole{ 0, 0, width, height };
  const PixelRectangle part = covered.Intersect(whole);
  const int rows =
    static_cast<int>(std::max<std::int64_t>(1, PixelsOfBand / std::max(1, part.Width)));
  for (int y = part.Y; y < part.GetTop(); y += rows)
  {
    const PixelRectangle band = PixelRectangle{ part.X, y, part.Width, rows }.Intersect(part);
    if (!this->PutOverBackground(colors, width, band, background))
    {
      return false;
    }
    textures.PutColors(inWindow(band), this->Band.data());
  }
  for (const PixelRectangle& outside : { PixelRectangle::FromEdges(0, 0, width, part.Y),
         PixelRectangle::FromEdges(0, part.GetTop(), width, height),
         PixelRectangle::FromEdges(0, part.Y, part.X, part.GetTop()),
         PixelRectangle::FromEdges(part.GetRight(), part.Y, width, part.GetTop()) })
  {
    textures.ClearColors(inWindow(outside), background);
  }
  if (!renderer->GetPreserveDepthBuffer())
  {
    textures.ClearDepths(inWindow(whole));
  }
  return true;
}

} // namespace isosurface
