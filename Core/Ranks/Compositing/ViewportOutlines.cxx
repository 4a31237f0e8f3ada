// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/ViewportOutlines.h"

#include "Ground/Base/Coding.h"

#include <array>
#include <cmath>

namespace isosurface
{
namespace
{

constexpr int LineWidth = 2;
constexpr int BlocksOfDash = 4;

// `x` and `y` are counted from the viewport's corner, so that dashes are the same on all tiles.
bool IsOnOutline(int x, int y, const PixelRectangle& viewport, int divisor)
{
  const bool isBesideColumn = x < LineWidth || x >= viewport.Width - LineWidth;
  const bool isBesideRow = y < LineWidth || y >= viewport.Height - LineWidth;
  const int dash = BlocksOfDash * divisor;
  const auto isDrawn = [divisor, dash](int along) { return divisor == 1 || along / dash % 2 == 0; };
  return (isBesideColumn && isDrawn(y)) || (isBesideRow && isDrawn(x));
}

} // namespace

std::uint32_t GetOutlineColor(int rank)
{
  // Hues at steps of the golden ratio, fully saturated to stand out from surfaces.
  const double hue = std::fmod(0.05 + 0.61803398875 * rank, 1.0) * 6;
  std::array<std::uint8_t, 4> bytes{ 0, 0, 0, 255 };
  for (std::size_t channel = 0; channel < 3; ++channel)
  {
    const double distance =
      std::fabs(std::fmod(hue + 6 - 2.0 * static_cast<double>(channel), 6) - 3);
    bytes[channel] = static_cast<std::uint8_t>(255 * std::fmin(1.0, std::fmax(0.0, distance - 1)));
  }
  return LoadLittleEndian<std::uint32_t>(bytes.data());
}

void DrawViewportOutlines(const std::vector<Viewport>& viewports, const DisplayLayout& display,
  const DisplayTile& tile, std::uint32_t* colors)
{
  const PixelRectangle shown = display.CoverWithPixels(tile.Pixels);
  const PixelRectangle extent = display.GetExtent();
  for (std::size_t rank = 0; rank < viewports.size(); ++rank)
  {
    // Whole blocks of pixels, as far as they are on the display.
    const int divisor = viewports[rank].Divisor;
    const PixelRectangle pixels =
      MakeViewport(display.CoverWithPixels(viewports[rank].GetPixels(extent)), divisor)
        .GetPixels(display.CoverWithPixels(extent));
    const PixelRectangle here = pixels.Intersect(shown);
    const std::uint32_t color = GetOutlineColor(static_cast<int>(rank));
    for (int y = here.Y; y < here.GetTop(); ++y)
    {
      std::uint32_t* row =
        colors + static_cast<std::size_t>(y - shown.Y) * static_cast<std::size_t>(shown.Width);
      for (int x = here.X; x < here.GetRight(); ++x)
      {
        if (IsOnOutline(x - pixels.X, y - pixels.Y, pixels, divisor))
        {
          row[x - shown.X] = color;
        }
      }
    }
  }
}

} // namespace isosurface
