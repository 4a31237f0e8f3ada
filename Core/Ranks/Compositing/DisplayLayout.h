// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DisplayLayout_h
#define isosurface_DisplayLayout_h

#include <algorithm>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Cells of a raster: columns [X, X + Width), rows [Y, Y + Height), rows from the bottom up as in
 * OpenGL. Without width or height it is empty, wherever it is.
 */
struct PixelRectangle
{
  int X = 0;
  int Y = 0;
  int Width = 0;
  int Height = 0;

  static PixelRectangle FromEdges(int left, int bottom, int right, int top)
  {
    return { left, bottom, std::max(0, right - left), std::max(0, top - bottom) };
  }

  int GetRight() const { return this->X + this->Width; }
  int GetTop() const { return this->Y + this->Height; }
  bool IsEmpty() const { return this->Width <= 0 || this->Height <= 0; }
  std::int64_t GetArea() const
  {
    return this->IsEmpty() ? 0 : static_cast<std::int64_t>(this->Width) * this->Height;
  }
  bool Contains(int x, int y) const
  {
    return x >= this->X && x < this->GetRight() && y >= this->Y && y < this->GetTop();
  }
  PixelRectangle Intersect(const PixelRectangle& other) const
  {
    return FromEdges(std::max(this->X, other.X), std::max(this->Y, other.Y),
      std::min(this->GetRight(), other.GetRight()), std::min(this->GetTop(), other.GetTop()));
  }
  /// The smallest rectangle that contains both; an empty one adds nothing.
  PixelRectangle Unite(const PixelRectangle& other) const
  {
    if (this->IsEmpty() || other.IsEmpty())
    {
      return this->IsEmpty() ? other : *this;
    }
    return FromEdges(std::min(this->X, other.X), std::min(this->Y, other.Y),
      std::max(this->GetRight(), other.GetRight()), std::max(this->GetTop(), other.GetTop()));
  }
  bool operator==(const PixelRectangle& other) const
  {
    return this->X == other.X && this->Y == other.Y && this->Width == other.Width &&
      this->Height == other.Height;
  }
};

/// The coarsest resolution of a viewport: blocks of 64 x 64 pixels.
constexpr int MaximumDivisor = 64;

/// The blocks of divisor x divisor pixels that have a pixel in the rectangle. Blocks are counted from
/// the display's pixel (0, 0); X and Y of the rectangle are not negative.
PixelRectangle CoverWithBlocks(const PixelRectangle& pixels, int divisor);

/**
 * The rectangle of a display that one rank draws at a resolution of its own: one sample for each
 * block of Divisor x Divisor pixels. Blocks of one divisor have the same places on all ranks: they
 * are counted from the display's low left pixel (0, 0), and the last ones may reach beyond its right
 * and upper edges. Viewports may overlap; a viewport may lie across tiles.
 *
 * After: W. Blanke, C. Bajaj, D. Fussell, X. Zhang, "The Metabuffer: a scalable multiresolution
 * multidisplay 3-D graphics system using commodity rendering engines", 2000. Here a
 * viewport may have any size at any resolution.
 */
struct Viewport
{
  int Divisor = 1;
  PixelRectangle Blocks; ///< in units of blocks; also the raster that the rank draws

  /// The pixels of a rectangle of the display that the viewport covers.
  PixelRectangle GetPixels(const PixelRectangle& rectangle) const;

  bool operator==(const Viewport& other) const
  {
    return this->Divisor == other.Divisor && this->Blocks == other.Blocks;
  }
};

/// The smallest viewport of a resolution that covers `pixels`, a rectangle of the display.
Viewport MakeViewport(const PixelRectangle& pixels, int divisor);

/// A screen of a wall: its rectangle of the display, and the rank that shows it.
struct DisplayTile
{
  PixelRectangle Pixels;
  int Rank = 0;
};

/**
 * The display that the ranks draw together: one tile, or several on a wall. Ranks draw samples, tiles
 * show pixels; with antialiasing a pixel has 2 x 2 samples.
 */
struct DisplayLayout
{
  std::vector<DisplayTile> Tiles; ///< in samples, counted from the display's low left corner
  int SamplesPerPixel = 1;        ///< in each direction: 1, or 2 with antialiasing

  /// The smallest rectangle of samples that begins at (0, 0) and contains all tiles.
  PixelRectangle GetExtent() const;

  /// The tile that a rank shows; null if there is none.
  const DisplayTile* FindTile(int rank) const;

  /// The pixels that have one of the samples.
  PixelRectangle CoverWithPixels(const PixelRectangle& samples) const;
};

/// A display with `samplesPerPixel` samples for each pixel of the tiles, in each direction.
DisplayLayout MakeDisplayLayout(const std::vector<DisplayTile>& tiles, int samplesPerPixel);

} // namespace isosurface

#endif
