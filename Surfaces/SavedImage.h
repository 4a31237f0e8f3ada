// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SavedImage_h
#define isosurface_SavedImage_h

#include <array>

namespace isosurface
{

/// Colors and depths of the framebuffer that is drawn to, kept bit for bit. All functions need the
/// window's context.
class SavedImage
{
public:
  /// Whether the framebuffer's colors and depths are textures, so that they can be saved.
  static bool IsPossible();

  /// Keeps what is in the viewport: x, y, width, height.
  void Save(const std::array<int, 4>& viewport);
  /// Puts it back.
  void Restore() const;
  bool IsEmpty() const { return this->Framebuffer == 0; }
  /// Forgets it.
  void Clear();

private:
  unsigned int Framebuffer = 0;
  std::array<unsigned int, 2> Textures{}; ///< of colors, and of depths
  std::array<int, 4> Viewport{};
};

} // namespace isosurface

#endif
