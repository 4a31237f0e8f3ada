// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffDescription_h
#define isosurface_TiffDescription_h

#include "Formats/Tiff/TiffFile.h"
#include "Formats/Tiff/TiffImage.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// What the descriptions of pages (tag ImageDescription) tell: the lines of ImageJ, or the JSON of
/// tifffile ({"shape": [2, 6, 32, 40], "axes": "CZYX"}).
namespace TiffDescription
{

/// The properties of ImageJ's text; nothing if it is another one.
std::optional<std::map<std::string, std::string>> FindImageJ(const std::string& text);
/// How many images a single directory of ImageJ or tifffile stands for; 1 if it stands for itself.
/// `format` is that of the directory.
std::int64_t CountImages(const std::string& text, const TiffFormat& format);

/// The image of ImageJ's text, whose pages are in the order of channels, slices, frames. Error: a
/// sentence without a file.
Result<TiffImage> MakeImageJ(
  const std::map<std::string, std::string>& text, const TiffContents& contents, std::int64_t pages);
/// The images of tifffile, each of which begins at a page with JSON. `axes` say what the axes of
/// pages are, if not empty. Error: a sentence without a file.
Result<std::vector<TiffImage>> MakeShaped(const TiffContents& contents, const std::string& axes);

} // namespace TiffDescription

} // namespace isosurface

#endif
