// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PixelRectangle_h
#define isosurface_PixelRectangle_h

#include <algorithm>
#include <cstdint>

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

} // namespace isosurface

#endif
