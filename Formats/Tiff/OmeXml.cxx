// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/OmeXml.h"

#include "Formats/Source/TextFields.h"

#include <pugixml.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace isosurface
{
namespace
{

constexpr std::size_t MaximumText = std::size_t{ 64 } << 20;
constexpr std::int64_t MaximumPlanes = std::int64_t{ 1 } << 24; ///< of an image
constexpr std::size_t MaximumImages = 65536;
/// Of an image; each is compared with those before.
constexpr std::size_t MaximumNamedChannels = 1024;

/// Whether an element has a name, whatever its prefix.
bool IsElement(const pugi::xml_node& node, const std::string& name)
{
  const std::string whole = node.name();
  const std::size_t colon = whole.rfind(':');
  return whole.compare(colon == std::string::npos ? 0 : colon + 1, std::string::npos, name) == 0;
}

pugi::xml_node FindElement(const pugi::xml_node& parent, const std::string& name)
{
  return parent.find_child([&name](const pugi::xml_node& node) { return IsElement(node, name); });
}

/// A whole number of at least 0; nothing if it is none or impossible.
std::optional<std::int64_t> FindCount(
  const pugi::xml_node& node, const char* name, std::int64_t otherwise)
{
  const pugi::xml_attribute attribute = node.attribute(name);
  const auto number = attribute ? ParseInteger(TrimText(attribute.value())) : otherwise;
  return number && *number >= -1 && (*number >= 0 || !attribute) && *number <= INT32_MAX
    ? number
    : std::nullopt;
}

/// A number above 0.
std::optional<double> FindLength(const pugi::xml_node& node, const std::string& name)
{
  const auto number = ParseDouble(TrimText(node.attribute(name.c_str()).value()));
  return number && std::isfinite(*number) && *number > 0 ? number : std::nullopt;
}

class OmeReader
{
public:
  OmeReader(const pugi::xml_node& root, std::string file)
    : Root(root)
    , File(std::move(file))
    , Uuid(root.attribute("UUID").value())
  {
  }

  Status Read(OmeXml& ome)
  {
    for (const pugi::xml_node& node : this->Root.children())
    {
      const pugi::xml_node pixels =
        IsElement(node, "Image") ? FindElement(node, "Pixels") : pugi::xml_node();
      if (!pixels)
      {
        continue;
      }
      if (ome.Images.size() == MaximumImages)
      {
        return Status(StatusCode::Unsupported, "its OME-XML has too many images");
      }
      ome.Images.emplace_back();
      TiffImage& image = ome.Images.back();
      image.Name = TrimText(node.attribute("Name").value());
      image.Id = node.attribute("ID").value();
      ISOSURFACE_RETURN_IF_ERROR(this->ReadSizes(pixels, image));
      this->ReadPlace(pixels, image);
      this->ReadTimes(pixels, image);
      this->ReadChannels(pixels, image);
      ISOSURFACE_RETURN_IF_ERROR(this->ReadRuns(pixels, image));
    }
    return Status::Ok();
  }

private:
  static Status ReadSizes(const pugi::xml_node& pixels, TiffImage& image)
  {
    const char* const names[] = { "SizeZ", "SizeC", "SizeT" };
    const std::string order = pixels.attribute("DimensionOrder").value();
    const std::string letters = "ZCT"; // as TiffImage::Axis
    double planes = 1;
    std::int64_t samples = 1; // of a pixel, which are channels of one page
    if (const pugi::xml_node channel = FindElement(pixels, "Channel"))
    {
      samples = std::max<std::int64_t>(1, FindCount(channel, "SamplesPerPixel", 1).value_or(1));
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const auto size = FindCount(pixels, names[axis], 1);
      const bool isOfPixel = axis == TiffImage::Channels && size && *size % samples == 0;
      image.Sizes[axis] = size.value_or(0) / (isOfPixel ? samples : 1);
      planes *= static_cast<double>(image.Sizes[axis]);
      const std::size_t place = order.find(letters[axis]);
      if (image.Sizes[axis] < 1 || order.size() != 5 || order.compare(0, 2, "XY") != 0 ||
        place == std::string::npos)
      {
        return Status(StatusCode::Corrupt,
          "its OME-XML has no " + std::string(names[axis]) +
            " above 0 or no possible DimensionOrder");
      }
      image.Order[place - 2] = axis;
    }
    if (planes > static_cast<double>(MaximumPlanes))
    {
      return Status(StatusCode::Unsupported,
        "its OME-XML has an image of more than " + std::to_string(MaximumPlanes) + " planes");
    }
    image.Width = FindCount(pixels, "SizeX", 0).value_or(0);
    image.Height = FindCount(pixels, "SizeY", 0).value_or(0);
    image.Type = pixels.attribute("Type").value();
    return Status::Ok();
  }

  static void ReadPlace(const pugi::xml_node& pixels, TiffImage& image)
  {
    std::array<std::string, 3> units;
    bool isAny = false;
    std::string missing;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const std::string name = std::string("PhysicalSize") + "XYZ"[axis];
      const auto length = FindLength(pixels, name);
      const pugi::xml_attribute unit = pixels.attribute((name + "Unit").c_str());
      units[axis] = unit ? NormalizeUnit(unit.value()) : "\u00B5m";
      image.Spacing[axis] = length.value_or(1);
      isAny = isAny || length;
      const bool isNeeded = axis < 2 || image.Sizes[TiffImage::Slices] > 1;
      missing += length || !isNeeded ? "" : (missing.empty() ? "" : ", ") + name;
      units[axis] = length || axis == 0 ? units[axis] : units[0];
    }
    if (!isAny)
    {
      return;
    }
    image.Unit = units[0];
    if (!UniteLengths(image.Spacing, units))
    {
      image.AddNote("its lengths have several units (" + units[0] + ", " + units[1] + ", " +
        units[2] + "), and are taken as they are");
    }
    if (!missing.empty())
    {
      image.AddNote(missing + " of OME-XML is missing, and taken as 1");
    }
  }

  static void ReadTimes(const pugi::xml_node& pixels, TiffImage& image)
  {
    const auto increment = FindLength(pixels, "TimeIncrement");
    image.TimeStep = increment.value_or(1);
    if (image.Sizes[TiffImage::Frames] > 1)
    {
      const std::string unit = pixels.attribute("TimeIncrementUnit").value();
      image.AddNote(increment
          ? "the unit of times, " + (unit.empty() ? std::string("s") : unit) + ", is not kept"
          : "times are numbered: OME-XML has no TimeIncrement");
    }
  }

  static void ReadChannels(const pugi::xml_node& pixels, TiffImage& image)
  {
    for (const pugi::xml_node& node : pixels.children())
    {
      if (IsElement(node, "Channel") && image.ChannelNames.size() < MaximumNamedChannels)
      {
        image.ChannelNames.push_back(TrimText(node.attribute("Name").value()));
      }
    }
  }

  /// The file of planes; empty: the own one.
  Result<std::string> FindFile(const pugi::xml_node& data) const
  {
    const pugi::xml_node node = FindElement(data, "UUID");
    const std::string uuid = TrimText(node.text().get());
    const std::string name = node.attribute("FileName").value();
    if (!node || (!uuid.empty() && uuid == this->Uuid) || name == this->File)
    {
      return std::string();
    }
    if (name.empty())
    {
      return Status(
        StatusCode::Unsupported, "its OME-XML names a file by its UUID alone (" + uuid + ")");
    }
    if (name.find_first_of("/\\") != std::string::npos || name == "." || name == "..")
    {
      return Status(StatusCode::Unsupported,
        "its OME-XML names a file outside of its folder, which is not read: " + name);
    }
    return name;
  }

  Status ReadRuns(const pugi::xml_node& pixels, TiffImage& image) const
  {
    for (const pugi::xml_node& node : pixels.children())
    {
      if (!IsElement(node, "TiffData"))
      {
        continue;
      }
      ISOSURFACE_ASSIGN_OR_RETURN(auto file, this->FindFile(node));
      const char* const names[] = { "FirstZ", "FirstC", "FirstT" };
      TiffImage::Run run;
      run.File = std::move(file);
      std::int64_t step = 1;
      for (const std::size_t axis : image.Order)
      {
        const auto first = FindCount(node, names[axis], 0);
        if (!first || *first >= image.Sizes[axis])
        {
          return Status(StatusCode::Corrupt,
            "a TiffData of its OME-XML has an impossible " + std::string(names[axis]));
        }
        run.FirstPlane += *first * step;
        step *= image.Sizes[axis];
      }
      const auto page = FindCount(node, "IFD", 0);
      const auto count = FindCount(node, "PlaneCount", node.attribute("IFD") ? 1 : -1);
      if (!page || !count)
      {
        return Status(
          StatusCode::Corrupt, "a TiffData of its OME-XML has an impossible IFD or PlaneCount");
      }
      run.FirstPage = *page;
      run.Count = *count;
      image.Runs.push_back(std::move(run));
    }
    return Status::Ok();
  }

  const pugi::xml_node& Root;
  std::string File;
  std::string Uuid;
};

} // namespace

bool OmeXml::IsOme(const std::string& text)
{
  const std::size_t end = text.find_last_not_of(std::string(" \t\r\n\0", 5));
  return end != std::string::npos && end >= 4 && text.compare(end - 3, 4, "OME>") == 0 &&
    text.find('<') != std::string::npos;
}

Result<OmeXml> OmeXml::Parse(const std::string& text, const std::string& file)
{
  if (text.size() > MaximumText)
  {
    return Status(StatusCode::Unsupported, "its OME-XML is larger than 64 MiB");
  }
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size(),
    pugi::parse_minimal | pugi::parse_escapes | pugi::parse_cdata | pugi::parse_wconv_attribute);
  const pugi::xml_node root = FindElement(document, "OME");
  if (!parsed || !root)
  {
    return Status(StatusCode::Corrupt,
      std::string("its OME-XML cannot be read: ") +
        (parsed ? "it has no element OME" : parsed.description()));
  }
  OmeXml ome;
  if (const pugi::xml_node binary = FindElement(root, "BinaryOnly"))
  {
    ome.MetadataFile = binary.attribute("MetadataFile").value();
    return !ome.MetadataFile.empty() && ome.MetadataFile.find_first_of("/\\") == std::string::npos
      ? Result<OmeXml>(std::move(ome))
      : Status(StatusCode::Unsupported,
          "its OME-XML is in another file, outside of its folder: " + ome.MetadataFile);
  }
  ISOSURFACE_RETURN_IF_ERROR(OmeReader(root, file).Read(ome));
  if (ome.Images.empty())
  {
    return Status(StatusCode::Corrupt, "its OME-XML has no image with pixels");
  }
  return ome;
}

} // namespace isosurface
