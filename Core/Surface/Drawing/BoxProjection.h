// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BoxProjection_h
#define isosurface_BoxProjection_h

#include <array>

namespace isosurface
{

/// Pixels [Left, Right) x [Bottom, Top), in an image or partly beyond it.
struct PixelBox
{
  int Left = 0;
  int Right = 0;
  int Bottom = 0;
  int Top = 0;
};

/// What of an image a box may cover.
struct ProjectedBox
{
  bool IsOutside = false; ///< not any of it
  /// If not, the box reaches the near plane or has no finite place, and Pixels mean nothing.
  bool IsKnown = false;
  PixelBox Pixels;
  /// Nothing in the box has a smaller depth: 0 at the near plane, 1 at the far one.
  float Depth = 0;
};

/**
 * Projects boxes to an image, as OpenGL does what is in them, but with a margin for the rounding of
 * graphics cards: a pixel on each side, 10^-5 of depth, and what single precision makes of a point
 * that is near the eye, or small in a large surface.
 */
class BoxProjection
{
public:
  /// `modelToClip`: row by row; it maps points of boxes to clip coordinates. The image's size is in
  /// pixels. `origin`: where the coordinates that are drawn are 0; they are in single precision.
  BoxProjection(const std::array<double, 16>& modelToClip, int width, int height,
    const std::array<double, 3>& origin = {});

  /// `bounds`: xmin, xmax, ymin ...; unknown if a minimum is above its maximum.
  ProjectedBox Project(const std::array<float, 6>& bounds) const;

private:
  std::array<double, 16> Matrix; ///< of places relative to Origin
  std::array<double, 3> Origin;
  double Width;
  double Height;
};

} // namespace isosurface

#endif
