// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Image_h
#define isosurface_Image_h

#include "Ranks/Compositing/DisplayLayout.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * An image in memory that somebody else owns: colors of four bytes (red, green, blue, alpha in the
 * order of addresses) and depths from 0 (near) to 1 (far), row by row from the bottom up. A pixel
 * is active if its depth is less than 1: something was drawn there.
 */
struct ImageView
{
  const std::uint32_t* Colors = nullptr;
  const float* Depths = nullptr;
  PixelRectangle Raster; ///< the place of the image in the raster that it belongs to

  std::size_t GetIndex(int x, int y) const
  {
    return static_cast<std::size_t>(y - this->Raster.Y) *
      static_cast<std::size_t>(this->Raster.Width) +
      static_cast<std::size_t>(x - this->Raster.X);
  }
};

/// An image that owns its memory.
struct ImageBuffer
{
  std::vector<std::uint32_t> Colors;
  std::vector<float> Depths;
  PixelRectangle Raster;

  /// Leaves the pixels undefined.
  void Resize(const PixelRectangle& raster)
  {
    this->Raster = raster;
    this->Colors.resize(static_cast<std::size_t>(raster.GetArea()));
    this->Depths.resize(static_cast<std::size_t>(raster.GetArea()));
  }
  /// Makes all pixels inactive: color 0, depth 1.
  void Clear(const PixelRectangle& raster)
  {
    this->Raster = raster;
    this->Colors.assign(static_cast<std::size_t>(raster.GetArea()), 0);
    this->Depths.assign(static_cast<std::size_t>(raster.GetArea()), 1.0F);
  }
  ImageView GetView() const { return { this->Colors.data(), this->Depths.data(), this->Raster }; }
};

} // namespace isosurface

#endif
