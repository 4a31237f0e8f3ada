// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_RandomImages_h
#define isosurface_Testing_RandomImages_h

#include "Ranks/Compositing/Image.h"

#include <random>
#include <utility>

namespace isosurface
{

/// Spans of active and inactive samples; depths from a few values, so that ranks are equally near.
inline ImageBuffer MakeRandomImage(const PixelRectangle& raster, unsigned seed)
{
  std::mt19937 random(seed);
  ImageBuffer image;
  image.Raster = raster;
  bool isActive = false;
  for (std::int64_t index = 0; index < raster.GetArea(); ++index)
  {
    isActive = random() % 7 == 0 ? !isActive : isActive;
    image.Colors.push_back(static_cast<std::uint32_t>(random()));
    image.Depths.push_back(isActive ? static_cast<float>(random() % 5) / 5.0F : 1.0F);
  }
  return image;
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
