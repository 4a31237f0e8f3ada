// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffDescription.h"

#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

namespace isosurface
{
namespace
{

/// The whole number behind `name` in a text, between two delimiters, of which the first is part of it.
std::int64_t FindNumber(const std::string& text, const std::string& name, const char* ends)
{
  const std::size_t place = text.find(name);
  if (place == std::string::npos)
  {
    return 1;
  }
  const std::size_t begin = place + name.size();
  return ParseInteger(TrimText(text.substr(begin, text.find_first_of(ends, begin) - begin)))
    .value_or(1);
}

} // namespace

TiffDescription TiffDescription::Parse(const std::string& text)
{
  TiffDescription description;
  if (text.compare(0, 7, "ImageJ=") == 0)
  {
    description.IsOfImageJ = true;
    description.Images = FindNumber(text, "\nimages=", "\n");
    description.Channels = FindNumber(text, "\nchannels=", "\n");
    description.Slices = FindNumber(text, "\nslices=", "\n");
    description.Frames = FindNumber(text, "\nframes=", "\n");
  }
  else if (text.find("openmicroscopy.org/") != std::string::npos)
  {
    // The element may have a prefix.
    const std::size_t begin = std::min(text.find("<Pixels "), text.find(":Pixels "));
    const std::string pixels =
      begin == std::string::npos ? "" : text.substr(begin, text.find('>', begin) - begin);
    description.Channels = FindNumber(pixels, " SizeC=\"", "\"");
    description.Slices = FindNumber(pixels, " SizeZ=\"", "\"");
    description.Frames = FindNumber(pixels, " SizeT=\"", "\"");
  }
  return description;
}

std::string TiffDescription::FindFault(std::int64_t pages) const
{
  const std::int64_t sizes[] = { this->Channels, this->Slices, this->Frames };
  const auto several =
    std::count_if(std::begin(sizes), std::end(sizes), [](std::int64_t size) { return size > 1; });
  return several < 2 || pages == this->Slices
    ? ""
    : "its images are of " + std::to_string(this->Channels) + " channels, " +
      std::to_string(this->Slices) + " slices and " + std::to_string(this->Frames) +
      " frames: only one stack of slices is read; save it as a file of its own";
}

} // namespace isosurface
