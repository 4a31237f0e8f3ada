// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PixelRuns_h
#define isosurface_PixelRuns_h

#include "Base/Communicator.h"
#include "Compositing/PixelRectangle.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * A picture in memory: pixels of four bytes (red, green, blue, alpha in the order of addresses) and
 * depths from 0 (near) to 1 (far), row by row from the bottom up. A pixel is active, that is,
 * something was drawn there, if its depth is less than 1. Not owned.
 */
struct ImageView
{
  const std::uint32_t* Colors = nullptr;
  const float* Depths = nullptr;
  PixelRectangle Raster; ///< the place of the picture in the raster that it is part of

  std::size_t GetIndex(int x, int y) const
  {
    return static_cast<std::size_t>(y - this->Raster.Y) *
      static_cast<std::size_t>(this->Raster.Width) +
      static_cast<std::size_t>(x - this->Raster.X);
  }
};

/// The index of the first active (or inactive) pixel of a row at `begin` or behind it; `end` if
/// there is none. Rows are empty for the most part, and are searched a block at a time.
int FindActive(const float* depths, int begin, int end);
int FindInactive(const float* depths, int begin, int end);

/// Whether depths travel with the colors: whoever merges needs them, whoever shows does not.
enum class PixelContent : std::uint8_t
{
  Colors,
  ColorsAndDepths
};

/// Active pixels of one row, side by side.
struct PixelRun
{
  int X = 0; ///< in the raster that the picture is part of
  int Y = 0;
  int Length = 0;
  std::size_t First = 0; ///< index of its first pixel among the active ones
};

/// The active pixels of a part of a picture.
struct ActivePixels
{
  std::vector<PixelRun> Runs; ///< row by row, from left to right
  std::vector<std::uint32_t> Colors;
  std::vector<float> Depths; ///< empty if they were not sent
};

/**
 * Appends the active pixels of `part`, which lies inside the picture's raster, in as few bytes as a
 * pass over them gives, without loss:
 *
 *     u32  bytes that follow
 *     u32  active pixels
 *     u8   bytes of a color: 4, or 3 if alpha is 255 all over
 *     u8   bytes of a depth: 4, 3, 2, or 0 if none are sent
 *     u32  lowest depth's bits (a float's bits are ordered as it is); depths are counted from it
 *     runs by turns: inactive pixels, active pixels, as LEB128, through all rows of the part, to
 * the last active one colors of the active pixels, then their depths
 *
 * All numbers are little-endian. Cost: two passes over the depths, one over the colors.
 */
void AppendActivePixels(
  const ImageView& picture, const PixelRectangle& part, PixelContent content, Message& bytes);

/**
 * Reads what AppendActivePixels wrote for the same `part` from `offset` on, and moves the offset
 * behind it. Corrupt if it cannot have been written so: whatever the bytes are, nothing is read
 * beyond their end, and no more is allocated than the part's pixels need.
 */
Status ReadActivePixels(const Message& bytes, const PixelRectangle& part, PixelContent content,
  std::size_t& offset, ActivePixels& pixels);

} // namespace isosurface

#endif
