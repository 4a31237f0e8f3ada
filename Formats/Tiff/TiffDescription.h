// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffDescription_h
#define isosurface_TiffDescription_h

#include <cstdint>
#include <string>

namespace isosurface
{

/// What the description of a file's first page (tag ImageDescription) tells of its images: ImageJ's
/// lines, or the first image of OME-XML. Everything is 1 in other texts.
struct TiffDescription
{
  /// Whether ImageJ wrote it, whose single directory may stand for all images.
  bool IsOfImageJ = false;
  std::int64_t Images = 1; ///< as ImageJ says
  std::int64_t Channels = 1;
  std::int64_t Slices = 1;
  std::int64_t Frames = 1;

  static TiffDescription Parse(const std::string& text);

  /**
   * Why so many pages are no stack of slices; empty if they are one. Pages that differ in a single thing
   * are one whatever that is called: tifffile says channels of any array of three axes. So are as many
   * as a stack has slices: a file of a set may have one channel of it.
   */
  std::string FindFault(std::int64_t pages) const;
};

} // namespace isosurface

#endif
