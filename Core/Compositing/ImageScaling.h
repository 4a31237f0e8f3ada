// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImageScaling_h
#define isosurface_ImageScaling_h

#include "Compositing/PixelRuns.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// A picture with memory of its own.
struct OwnImage
{
  std::vector<std::uint32_t> Colors;
  std::vector<float> Depths;
  PixelRectangle Raster;

  void Resize(const PixelRectangle& raster);
  ImageView GetView() const { return { this->Colors.data(), this->Depths.data(), this->Raster }; }
};

/**
 * Enlarges a picture of one sample for each block of divisor x divisor pixels to `pixels`, which
 * its blocks cover. Depths, and what is active, are those of a pixel's block; colors go over
 * linearly from the middles of blocks to those of the neighbors, as far as these are active, so
 * silhouettes do not fray and the background does not bleed.
 *
 * All is computed in integers: of the up to four samples around a pixel, each byte of the color is
 * the mean, by the products of the distances to the middles in half pixels, rounded half up.
 * Pixels without an active sample become 0.
 */
void EnlargeSmoothly(
  const ImageView& picture, int divisor, const PixelRectangle& pixels, OwnImage& enlarged);

/**
 * Makes a picture of width x height pixels from one of twice the size in both directions: each byte
 * of a color is the mean of four, rounded half up, and the depth the nearest one. `coarseDepths` is
 * null if there are no depths.
 */
void AverageSamples(const std::uint32_t* fineColors, const float* fineDepths, int width, int height,
  std::uint32_t* coarseColors, float* coarseDepths);

} // namespace isosurface

#endif
