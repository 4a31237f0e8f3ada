// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/Viewport.h"

namespace isosurface
{

PixelRectangle CoverWithBlocks(const PixelRectangle& pixels, int divisor)
{
  if (pixels.IsEmpty())
  {
    return {};
  }
  return PixelRectangle::FromEdges(pixels.X / divisor, pixels.Y / divisor,
    (pixels.GetRight() + divisor - 1) / divisor, (pixels.GetTop() + divisor - 1) / divisor);
}

PixelRectangle Viewport::GetPixels(const PixelRectangle& rectangle) const
{
  const PixelRectangle covered{ this->Blocks.X * this->Divisor, this->Blocks.Y * this->Divisor,
    this->Blocks.Width * this->Divisor, this->Blocks.Height * this->Divisor };
  return covered.Intersect(rectangle);
}

Viewport MakeViewport(const PixelRectangle& pixels, int divisor)
{
  return { divisor, CoverWithBlocks(pixels, divisor) };
}

} // namespace isosurface
