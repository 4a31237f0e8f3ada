// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_RandomImages_h
#define isosurface_Testing_RandomImages_h

#include "Compositing/PixelRuns.h"
#include "Compositing/Viewport.h"

#include <random>
#include <vector>

namespace isosurface
{

/// A picture with its memory.
struct OwnImage
{
  std::vector<std::uint32_t> Colors;
  std::vector<float> Depths;
  PixelRectangle Raster;

  ImageView GetView() const { return { this->Colors.data(), this->Depths.data(), this->Raster }; }
};

/// Spans of active and inactive samples; depths from a few values, so that ranks are equally near.
inline OwnImage MakeRandomImage(const PixelRectangle& raster, unsigned seed)
{
  std::mt19937 random(seed);
  OwnImage picture;
  picture.Raster = raster;
  bool isActive = false;
  for (std::int64_t index = 0; index < raster.GetArea(); ++index)
  {
    isActive = random() % 7 == 0 ? !isActive : isActive;
    picture.Colors.push_back(static_cast<std::uint32_t>(random()));
    picture.Depths.push_back(isActive ? static_cast<float>(random() % 5) / 5.0F : 1.0F);
  }
  return picture;
}

/// Any rectangle inside of one.
inline PixelRectangle MakeRandomRectangle(const PixelRectangle& inside, std::mt19937& random)
{
  const auto edges = [&random](int begin, int length)
  {
    int a = begin + static_cast<int>(random() % static_cast<unsigned>(length + 1));
    int b = begin + static_cast<int>(random() % static_cast<unsigned>(length + 1));
    return std::pair<int, int>{ std::min(a, b), std::max(a, b) };
  };
  const auto columns = edges(inside.X, inside.Width);
  const auto rows = edges(inside.Y, inside.Height);
  return PixelRectangle::FromEdges(columns.first, rows.first, columns.second, rows.second);
}

} // namespace isosurface

#endif
