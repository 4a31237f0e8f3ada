// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImageScaling_h
#define isosurface_ImageScaling_h

#include "Ranks/Compositing/Image.h"

namespace isosurface
{

/**
 * Upsamples an image of one sample for each block of divisor x divisor pixels: every pixel gets the
 * sample of its block. Only `pixels` of `upsampled` are written; they lie inside its raster, and the
 * image's blocks cover them.
 */
void UpsampleBlocks(
  const ImageView& image, int divisor, const PixelRectangle& pixels, ImageBuffer& upsampled);

/**
 * Upsamples an image of one sample for each block of divisor x divisor pixels by bilinear
 * interpolation. `upsampled` becomes an image of `pixels`, which the image's blocks cover.
 *
 * A pixel has its block's depth; it is active if its block is. Its color is interpolated between the
 * centers of the up to four blocks around it, the active ones only, so that silhouettes stay sharp
 * and the background does not bleed in. All is computed in integers: each byte of the color is a
 * mean weighted by the products of the distances in half pixels, rounded half up. Inactive pixels
 * get color 0.
 */
void UpsampleSmoothly(
  const ImageView& image, int divisor, const PixelRectangle& pixels, ImageBuffer& upsampled);

/**
 * Downsamples an image to width x height pixels from twice as many in both directions. Each byte of
 * a color is the mean of four, rounded half up; the depth is the minimum of four. `coarseDepths` is
 * null if there are no depths.
 */
void AverageSamples(const std::uint32_t* fineColors, const float* fineDepths, int width, int height,
  std::uint32_t* coarseColors, float* coarseDepths);

} // namespace isosurface

#endif
