// SPDX-License-Identifier: BSD-3-Clause
#include "ImageDelivery.h"

#include "DrawTextures.h"
#include "OpenGLFunctions.h"
#include "Ranks/Compositing/Background.h"

#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLRenderer.h"
#include "vtkOpenGLState.h"

#include <algorithm>

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

bool ImageDelivery::Deliver(vtkOpenGLRenderer* renderer, const std::uint32_t* colors, int width,
  int height, const PixelRectangle& covered)
{
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetVTKWindow());
  const PixelRectangle place = GetPlaceInWindow(renderer);
  const DrawTextures textures;
  if (!window || place.Width != width || place.Height != height || !HasPlainBackground(renderer) ||
    !textures.HavePlainColors())
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
    const PixelRectangle band = PixelRectangle{ inside.X, y, inside.Width, rows }.Intersect(inside);
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

} // namespace isosurface
