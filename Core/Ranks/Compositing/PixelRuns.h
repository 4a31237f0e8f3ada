// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PixelRuns_h
#define isosurface_PixelRuns_h

#include "Ground/Base/Communicator.h"
#include "Ranks/Compositing/Image.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Whether depths are sent with the colors: merging needs them, showing does not.
enum class PixelContent : std::uint8_t
{
  Colors,
  ColorsAndDepths
};

/// Active pixels of one row, side by side.
struct PixelRun
{
  int X = 0; ///< in the raster that the image belongs to
  int Y = 0;
  int Length = 0;
  std::size_t First = 0; ///< index of its first pixel among the active ones
};

/// The active pixels of a rectangle of an image.
struct ActivePixels
{
  std::vector<PixelRun> Runs; ///< row by row, from left to right
  std::vector<std::uint32_t> Colors;
  std::vector<float> Depths; ///< empty if they were not sent
};

/// The index of the first active (inactive) pixel of a row from `begin` on; `end` if there is none.
int FindActive(const float* depths, int begin, int end);
int FindInactive(const float* depths, int begin, int end);

/// Calls use(run, its colors, its depths) for the active pixels of a rectangle of an image, which
/// lies inside its raster. The runs' First counts from 0.
template <typename Function>
void ForEachActiveRun(const ImageView& image, const PixelRectangle& rectangle, const Function& use)
{
  std::size_t count = 0;
  for (int y = rectangle.Y; y < rectangle.GetTop(); ++y)
  {
    const std::size_t row = image.GetIndex(rectangle.X, y);
    const std::uint32_t* colors = image.Colors + row;
    const float* depths = image.Depths + row;
    for (int begin = FindActive(depths, 0, rectangle.Width); begin < rectangle.Width;)
    {
      const int end = FindInactive(depths, begin, rectangle.Width);
      use(PixelRun{ rectangle.X + begin, y, end - begin, count }, colors + begin, depths + begin);
      count += static_cast<std::size_t>(end - begin);
      begin = FindActive(depths, end, rectangle.Width);
    }
  }
}

// The bytes of the active pixels of a rectangle; all integers are little-endian.
//
//   offset  size  content
//        0     4  number of bytes that follow
//        4     4  number of active pixels, n
//        8     1  bytes of a color, c: 4; 3 if alpha is 255 in all of them, which is not stored then
//        9     1  bytes of a depth, d: 4, 3 or 2; 0 if no depths are sent
//       10     4  bits of the minimum depth, as an integer (positive floats have the same order)
//       14        lengths of runs, each a varint: inactive, active, inactive, active, ..., through all
//                 rows of the rectangle, up to the last active pixel
//             cn  colors of the active pixels: red, green, blue, alpha
//             dn  depths of the active pixels: bits minus the bits of the minimum depth

/**
 * Appends the active pixels of a rectangle of an image, without loss. The rectangle lies inside the
 * image's raster. Cost: two passes over the depths, one over the colors.
 */
void AppendActivePixels(
  const ImageView& image, const PixelRectangle& rectangle, PixelContent content, Message& bytes);

/**
 * Reads what AppendActivePixels wrote of the same rectangle from `offset` on, and moves the offset to
 * its end. Corrupt if AppendActivePixels cannot have written it. Never reads beyond the end of the
 * bytes, nor allocates more than the rectangle's pixels need.
 */
Status ReadActivePixels(const Message& bytes, const PixelRectangle& rectangle, PixelContent content,
  std::size_t& offset, ActivePixels& pixels);

} // namespace isosurface

#endif
