// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DepthPyramid_h
#define isosurface_DepthPyramid_h

#include "Surface/Drawing/BoxProjection.h"

#include <vector>

namespace isosurface
{

/**
 * The depths of an image, so that it is quick to tell that a box is behind what has been drawn: the
 * farthest one of each square of pixels, and of squares of squares.
 *
 * Source: N. Greene, M. Kass, G. Miller, "Hierarchical Z-buffer visibility", 1993.
 */
class DepthPyramid
{
public:
  /// Takes depths from 0 (near) to 1 (far), row by row from the bottom. Cost: a visit to each.
  void Build(const std::vector<float>& depths, int width, int height);

  /// The smallest squares, of which ranks tell each other (SharedDepths), row by row from the bottom.
  static constexpr int SquareSide = 4;
  static int CountSquares(int pixels) { return (pixels + SquareSide - 1) / SquareSide; }
  const std::vector<float>& GetSquares() const { return this->Levels.front().Farthest; }
  bool HasSize(int width, int height) const
  {
    return this->Width == width && this->Height == height;
  }
  /// Makes no square farther than it is told here, one number for each.
  void BringNearer(const std::vector<float>& squares);

  /// Whether all pixels of the box that are in the image are nearer than the box. False if that is
  /// not certain: squares of pixels are looked at as a whole. True if none is in the image. False of
  /// all boxes before there is an image.
  bool IsBehind(const ProjectedBox& box) const;

private:
  struct Level
  {
    int Width = 0;
    int Height = 0;
    std::vector<float> Farthest;
  };

  void AddCoarserLevels();
  void AddCoarserLevel();

  int Width = 0;
  int Height = 0;
  std::vector<Level> Levels; ///< each of squares twice as wide as the one before
};

} // namespace isosurface

#endif
