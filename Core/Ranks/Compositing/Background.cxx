// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/Background.h"

#include <array>
#include <cstddef>
#include <cstring>

namespace isosurface
{
namespace
{

bool IsOpaque(std::uint32_t color)
{
  std::array<std::uint8_t, 4> bytes{};
  std::memcpy(bytes.data(), &color, sizeof(color));
  return bytes[3] == 255;
}

} // namespace

bool PutOverBackground(const std::uint32_t* colors, int width, const PixelRectangle& rectangle,
  std::uint32_t background, std::vector<std::uint32_t>& result)
{
  result.resize(static_cast<std::size_t>(rectangle.GetArea()));
  std::uint32_t* to = result.data();
  bool isPlain = true;
  for (int y = rectangle.Y; y < rectangle.GetTop(); ++y)
  {
    const std::uint32_t* from =
      colors + static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + rectangle.X;
    bool isRowPlain = true; // without a branch for each pixel
    for (int x = 0; x < rectangle.Width; ++x)
    {
      const std::uint32_t color = from[x];
      const bool isOpaque = IsOpaque(color);
      isRowPlain &= isOpaque | (color == 0);
      to[x] = isOpaque ? color : background;
    }
    to += rectangle.Width;
    isPlain = isPlain && isRowPlain;
  }
  return isPlain;
}

} // namespace isosurface
