// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffDescription.h"

#include "Formats/Source/TextFields.h"
#include "Formats/Zarr/JsonField.h"
#include "Ground/Volume/LengthUnit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <sstream>

namespace isosurface::TiffDescription
{
namespace
{

using Properties = std::map<std::string, std::string>;
using Json = nlohmann::json;

constexpr std::int64_t MostImages = std::int64_t{ 1 } << 31;

/// "\u00B5" as the letter that it stands for, in UTF-8, as Java writes properties.
std::string UndoEscapes(const std::string& text)
{
  std::string plain;
  for (std::size_t at = 0; at < text.size(); ++at)
  {
    const bool isEscape = text.compare(at, 2, "\\u") == 0 && at + 6 <= text.size() &&
      text.find_first_not_of("0123456789abcdefABCDEF", at + 2) >= at + 6;
    if (!isEscape)
    {
      plain += text[at];
      continue;
    }
    const auto code = static_cast<unsigned>(std::stoul(text.substr(at + 2, 4), nullptr, 16));
    const auto add = [&plain](unsigned byte) { plain += static_cast<char>(byte); };
    if (code < 0x80)
    {
      add(code);
    }
    else if (code < 0x800)
    {
      add(0xC0 | (code >> 6));
      add(0x80 | (code & 0x3F));
    }
    else
    {
      add(0xE0 | (code >> 12));
      add(0x80 | ((code >> 6) & 0x3F));
      add(0x80 | (code & 0x3F));
    }
    at += 5;
  }
  return plain;
}

std::string FindText(const Properties& properties, const std::string& name)
{
  const auto found = properties.find(name);
  return found == properties.end() ? "" : found->second;
}

/// A number of the properties; nothing if there is none or an impossible one.
std::optional<double> FindReal(const Properties& properties, const std::string& name)
{
  const auto number = ParseDouble(FindText(properties, name));
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::int64_t FindSize(const Properties& properties, const std::string& name)
{
  const std::int64_t size = ParseInteger(FindText(properties, name)).value_or(1);
  return std::clamp<std::int64_t>(size, 1, MostImages);
}

void TakePlace(const Properties& text, const TiffContents& contents, TiffImage& image)
{
  image.Unit = NormalizeUnit(FindText(text, "unit"));
  const auto depth = FindReal(text, "spacing");
  const bool hasScale = !image.Unit.empty() || depth;
  // 72 an inch is no scale to ImageJ.
  const bool isOfScreen = contents.ResolutionUnit == 2 && contents.XResolution == 72;
  const auto invert = [isOfScreen](double perUnit)
  { return std::isfinite(perUnit) && perUnit > 0 && !isOfScreen ? 1 / perUnit : 1; };
  if (hasScale)
  {
    image.Spacing = { invert(contents.XResolution), invert(contents.YResolution),
      depth && *depth != 0 ? std::abs(*depth) : 1 };
  }
  if (contents.ResolutionUnit == 3 &&
    FindLengthUnit(image.Unit) == LengthUnit::Micrometer) // of a centimetre, as ImageJ takes it
  {
    image.Spacing[0] *= 1e4;
    image.Spacing[1] *= 1e4;
  }
  if (hasScale && !depth && image.Sizes[TiffImage::Slices] > 1)
  {
    image.AddNote("ImageJ does not tell the distance of slices, which is taken as 1");
  }
  const char* const names[] = { "yunit", "zunit" };
  std::array<std::string, 3> units = { image.Unit, image.Unit, image.Unit };
  for (std::size_t axis = 1; axis < 3; ++axis)
  {
    const std::string unit = FindText(text, names[axis - 1]);
    units[axis] = unit.empty() ? image.Unit : NormalizeUnit(UndoEscapes(unit));
  }
  if (!UniteLengths(image.Spacing, units))
  {
    image.AddNote("its lengths have several units (" + units[0] + ", " + units[1] + ", " +
      units[2] + "), and are taken as they are");
  }
  const char* const origins[] = { "xorigin", "yorigin", "zorigin" };
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    image.Origin[axis] = -FindReal(text, origins[axis]).value_or(0) * image.Spacing[axis];
  }
}

void TakeCalibration(const Properties& text, TiffImage& image)
{
  const auto function = FindReal(text, "cf");
  if (!function)
  {
    return;
  }
  const double offset = FindReal(text, "c0").value_or(0);
  const double slope = FindReal(text, "c1").value_or(0);
  const std::string unit = FindText(text, "vunit");
  if (*function == 0 && offset == -32768 && slope == 1)
  {
    image.IsOffset = true;
    image.SampleUnit = unit == "Gray Value" ? "" : unit;
  }
  else if (*function != 0 || offset != 0 || slope != 1)
  {
    image.AddNote("samples are the numbers of the file: ImageJ's calibration (function " +
      FindText(text, "cf") + ": " + FindText(text, "c0") + ", " + FindText(text, "c1") + ", ... " +
      unit + ") is not applied");
  }
}

void TakeTimesOfImageJ(const Properties& text, TiffImage& image)
{
  const auto interval = FindReal(text, "finterval");
  if (image.Sizes[TiffImage::Frames] > 1)
  {
    image.TimeStep = interval && *interval > 0 ? *interval : 1;
    const std::string unit = FindText(text, "tunit");
    image.AddNote(interval && *interval > 0
        ? "the unit of times, " + (unit.empty() ? std::string("s") : unit) + ", is not kept"
        : "times are numbered: ImageJ's finterval is missing");
  }
}

/// Sets the sizes and the order of pages from letters of axes, the slowest first.
Status TakeAxes(
  const std::string& letters, const std::vector<std::int64_t>& sizes, TiffImage& image)
{
  std::size_t next = 0;
  image.Sizes = { 1, 1, 1 };
  std::array<bool, 3> isKnown = {};
  const std::string known = "ZCT"; // as TiffImage::Axis
  for (std::size_t at = letters.size(); at-- > 0;)
  {
    const std::size_t axis = known.find(letters[at]);
    if (axis == std::string::npos || isKnown[axis])
    {
      return Status(StatusCode::Unsupported,
        "its axes are " + letters + "YX, and \"" + letters[at] +
          (axis == std::string::npos ? "\" is none of slices (Z), channels (C) and times (T)"
                                     : "\" stands there twice") +
          "; --axes says what they are");
    }
    isKnown[axis] = true;
    image.Sizes[axis] = sizes[at];
    image.Order[next++] = axis;
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (!isKnown[axis])
    {
      image.Order[next++] = axis;
    }
  }
  return Status::Ok();
}

/// The axes of pages: those before y and x, without samples of a pixel and without those of size 1.
struct PageAxes
{
  std::string Letters;
  std::vector<std::int64_t> Sizes;
  std::int64_t Pages = 1;
};

/// Nothing if the shape is not of pages of this format.
std::optional<PageAxes> FindPageAxes(const Json& json, const TiffFormat& format)
{
  const Json& shape = FindJson(json, "shape");
  std::vector<std::int64_t> sizes;
  double product = 1;
  for (const Json& size : shape.is_array() ? shape : Json::array())
  {
    sizes.push_back(size.is_number_integer() ? size.get<std::int64_t>() : 0);
    product *= static_cast<double>(sizes.back());
    if (sizes.back() < 1 || product > 1e18 || sizes.size() > 32)
    {
      return std::nullopt;
    }
  }
  std::string letters = GetJsonText(FindJson(json, "axes"));
  letters = letters.size() == sizes.size() ? letters : std::string(sizes.size(), 'Q');
  const auto drop = [&](std::int64_t size)
  {
    const bool isLast = !sizes.empty() && sizes.back() == size;
    sizes.resize(sizes.size() - (isLast ? 1 : 0));
    letters.resize(sizes.size());
    return isLast;
  };
  const std::int64_t samples = format.Components;
  if ((samples > 1 || (letters.size() > 1 && letters.back() == 'S')) && !drop(samples))
  {
    return std::nullopt;
  }
  if (!drop(format.Width) || !drop(format.Height) || (format.Planes > 1 && !drop(format.Planes)))
  {
    return std::nullopt;
  }
  PageAxes axes;
  for (std::size_t axis = 0; axis < sizes.size(); ++axis)
  {
    axes.Pages *= sizes[axis];
    if (sizes[axis] > 1)
    {
      axes.Letters += letters[axis];
      axes.Sizes.push_back(sizes[axis]);
    }
  }
  return axes;
}

/// Letters that tell nothing (Q, I) as those of the usual order.
std::string NameUnknown(std::string letters)
{
  const char* const usual[] = { "", "Z", "TZ", "TCZ" };
  if (letters.find_first_not_of("QI") == std::string::npos && letters.size() <= 3)
  {
    return usual[letters.size()];
  }
  const std::size_t unknown = letters.find_last_of("QI");
  if (letters.find('Z') == std::string::npos && unknown != std::string::npos)
  {
    letters[unknown] = 'Z';
  }
  return letters;
}

} // namespace

std::optional<Properties> FindImageJ(const std::string& text)
{
  if (text.compare(0, 7, "ImageJ=") != 0)
  {
    return std::nullopt;
  }
  Properties properties;
  std::istringstream lines(text.substr(0, 65536));
  for (std::string line; std::getline(lines, line);)
  {
    const std::size_t equal = line.find('=');
    if (equal != std::string::npos)
    {
      properties[line.substr(0, equal)] = UndoEscapes(TrimText(line.substr(equal + 1)));
    }
  }
  return properties;
}

std::int64_t CountImages(const std::string& text, const TiffFormat& format)
{
  if (const auto properties = FindImageJ(text))
  {
    return FindSize(*properties, "images");
  }
  const Json json = Json::parse(text, nullptr, false);
  const Json& truncated = FindJson(json, "truncated");
  const auto axes =
    truncated.is_boolean() && truncated.get<bool>() ? FindPageAxes(json, format) : std::nullopt;
  return axes ? axes->Pages : 1;
}

Result<TiffImage> MakeImageJ(
  const Properties& text, const TiffContents& contents, std::int64_t pages)
{
  TiffImage image;
  image.Sizes = { FindSize(text, "slices"), FindSize(text, "channels"), FindSize(text, "frames") };
  std::string order = FindText(text, "order");
  image.Order = { TiffImage::Channels, TiffImage::Slices, TiffImage::Frames };
  if (!order.empty() && order != "default")
  {
    std::string sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t place = 0; sorted == "ctz" && place < 3; ++place)
    {
      image.Order[place] = std::string("zct").find(order[place]);
    }
    if (sorted != "ctz")
    {
      return Status(StatusCode::Unsupported, "ImageJ's order of its images is " + order);
    }
  }
  const TiffFormat& format = contents.Formats.front();
  if (image.Sizes[TiffImage::Channels] == format.Components * format.Planes)
  {
    image.Sizes[TiffImage::Channels] = 1; // they are the samples of a pixel
  }
  const double planes = static_cast<double>(image.Sizes[0]) * static_cast<double>(image.Sizes[1]) *
    static_cast<double>(image.Sizes[2]);
  if (planes != static_cast<double>(pages) && pages > 1)
  {
    const auto several = std::count_if(
      image.Sizes.begin(), image.Sizes.end(), [](std::int64_t size) { return size > 1; });
    if (several > 1)
    {
      return Status(StatusCode::Unsupported,
        "its images are of " + image.DescribeSizes() + ", but there are " + std::to_string(pages) +
          " pages");
    }
    if (several == 1)
    {
      image.AddNote("its " + std::to_string(pages) +
        " pages are taken as slices; ImageJ's text is of " + image.DescribeSizes());
    }
    image.Sizes = { pages, 1, 1 };
  }
  else if (pages == 1)
  {
    image.Sizes = { 1, 1, 1 };
  }
  image.TakePagesAsSlices();
  image.Runs = { { "", 0, 0, pages } };
  TakePlace(text, contents, image);
  TakeCalibration(text, image);
  TakeTimesOfImageJ(text, image);
  return image;
}

Result<std::vector<TiffImage>> MakeShaped(const TiffContents& contents, const std::string& axes)
{
  const std::vector<TiffPage>& pages = contents.Pages;
  const auto& texts = contents.Shapes;
  std::vector<TiffImage> images;
  const auto count = static_cast<std::int64_t>(pages.size());
  std::size_t next = 0; // of the JSON
  bool hasLonePagesAlone = true;
  for (std::int64_t page = 0; page < count;)
  {
    const bool isShaped = next < texts.size() && texts[next].first == page;
    const Json json = isShaped ? Json::parse(texts[next].second, nullptr, false) : Json();
    next += isShaped ? 1 : 0;
    const std::int64_t end = next < texts.size() ? texts[next].first : count;
    const TiffPage& first = pages[static_cast<std::size_t>(page)];
    const auto found = first.Format >= 0
      ? FindPageAxes(json, contents.Formats[static_cast<std::size_t>(first.Format)])
      : std::nullopt;
    images.emplace_back();
    TiffImage& image = images.back();
    if (found && found->Pages > end - page)
    {
      return Status(StatusCode::Corrupt,
        "truncated: the description of page " + std::to_string(page + 1) + " speaks of " +
          std::to_string(found->Pages) + " pages");
    }
    const std::int64_t own = found ? found->Pages : end - page;
    image.Sizes = { own, 1, 1 };
    image.Runs = { { "", page, 0, own } };
    hasLonePagesAlone = hasLonePagesAlone && own == 1;
    const std::string letters = !axes.empty() ? axes : found ? found->Letters : "";
    if (found && !letters.empty())
    {
      std::string upper = letters;
      std::transform(upper.begin(), upper.end(), upper.begin(),
        [](unsigned char letter) { return static_cast<char>(std::toupper(letter)); });
      const Status status = upper.size() == found->Sizes.size()
        ? TakeAxes(NameUnknown(upper), found->Sizes, image)
        : Status(StatusCode::InvalidArgument,
            "it has " + std::to_string(found->Sizes.size()) + " axes of pages, not " +
              std::to_string(upper.size()));
      // Only the image that is opened has to be understood.
      image.Fault = status;
    }
    image.TakePagesAsSlices();
    page += own;
  }
  if (hasLonePagesAlone && images.size() > 1)
  {
    images.resize(1);
    images[0].Sizes = { count, 1, 1 };
    images[0].Runs = { { "", 0, 0, count } };
    images[0].AddNote(
      "its " + std::to_string(count) + " images of a page each are taken as slices");
  }
  return images;
}

} // namespace isosurface::TiffDescription
