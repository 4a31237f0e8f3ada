// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/DisplayLayout.h"

#include <algorithm>

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

PixelRectangle DisplayLayout::GetExtent() const
{
  PixelRectangle extent;
  for (const DisplayTile& tile : this->Tiles)
  {
    extent = PixelRectangle::FromEdges(0, 0, std::max(extent.GetRight(), tile.Pixels.GetRight()),
      std::max(extent.GetTop(), tile.Pixels.GetTop()));
  }
  return extent;
}

const DisplayTile* DisplayLayout::FindTile(int rank) const
{
  const auto tile = std::find_if(this->Tiles.begin(), this->Tiles.end(),
    [rank](const DisplayTile& candidate) { return candidate.Rank == rank; });
  return tile == this->Tiles.end() ? nullptr : &*tile;
}

PixelRectangle DisplayLayout::CoverWithPixels(const PixelRectangle& samples) const
{
  return CoverWithBlocks(samples, this->SamplesPerPixel);
}

DisplayLayout MakeDisplayLayout(const std::vector<DisplayTile>& tiles, int samplesPerPixel)
{
  DisplayLayout display{ tiles, samplesPerPixel };
  for (DisplayTile& tile : display.Tiles)
  {
    tile.Pixels = { samplesPerPixel * tile.Pixels.X, samplesPerPixel * tile.Pixels.Y,
      samplesPerPixel * tile.Pixels.Width, samplesPerPixel * tile.Pixels.Height };
  }
  return display;
}

} // namespace isosurface
