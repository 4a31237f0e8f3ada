// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/ArraySource.h"
#include "Formats/Source/FormatFunctions.h"
#include "Formats/Source/SliceFiles.h"
#include "Formats/Tiff/TiffImages.h"
#include "Formats/Tiff/TiffPlanes.h"
#include "Formats/Tiff/TiffImage.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

const char* const ArrayName = "Tiff Scalars";

/// What a channel is called, among those before it.
std::string NameChannel(
  const TiffImage& image, std::int64_t channel, const std::vector<VolumeArray>& parts)
{
  const auto number = static_cast<std::size_t>(channel);
  const std::string name = number < image.ChannelNames.size() ? image.ChannelNames[number] : "";
  const bool isNew = std::none_of(
    parts.begin(), parts.end(), [&name](const VolumeArray& part) { return part.Name == name; });
  return !name.empty() && isNew ? name : ArrayName + std::string(" ") + std::to_string(channel);
}

/// The arrays of all channels, and of the planes of each.
Result<std::vector<VolumeArray>> MakeChannels(
  FileSystem& files, const TiffPlanes& planes, const TiffImage& image)
{
  const auto paths = std::make_shared<const std::vector<std::string>>(planes.GetPaths());
  const TiffFormat& format = planes.GetFormat();
  const bool hasComponents = format.Components > 1;
  const auto axes = ArrayAxes::Parse(hasComponents ? "zyxc" : "zyx", hasComponents ? 4 : 3);
  const bool isAlone = image.Sizes[TiffImage::Channels] == 1 && format.Planes == 1;
  std::vector<VolumeArray> parts;
  for (const auto& [channel, slices] : planes.GetChannels())
  {
    for (std::int64_t plane = 0; plane < format.Planes; ++plane)
    {
      std::vector<TiffSlice> ofPlane = slices;
      for (TiffSlice& slice : ofPlane)
      {
        slice.Page.Plane = static_cast<std::uint16_t>(plane);
      }
      ISOSURFACE_ASSIGN_OR_RETURN(
        auto array, TiffArray::Open(files, paths, std::move(ofPlane), format, image.IsOffset));
      const std::string name =
        isAlone ? ArrayName : NameChannel(image, channel * format.Planes + plane, parts);
      ISOSURFACE_ASSIGN_OR_RETURN(
        const auto made, MakeVolumeArrays(name, std::move(array), *axes, 0));
      parts.insert(parts.end(), made.begin(), made.end());
    }
  }
  return parts;
}

/// Sets spacing, origin and times, and what is told.
void TakePlaceAndNotes(const TiffPlanes& planes, TiffImage& image, OpenedVolume& volume)
{
  for (ArrayDescription& array : volume.Arrays)
  {
    array.Unit = image.SampleUnit;
  }
  volume.Level = static_cast<int>(planes.GetLevel());
  const std::array<double, 3>& steps = planes.GetSteps();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    volume.Grid.Spacing[axis] = image.Spacing[axis] * steps[axis];
    // A sample of a level is in the middle of those of the page that it stands for.
    const double middle = axis < 2 ? (steps[axis] - 1) / 2 : 0;
    volume.Grid.Origin[axis] = image.Origin[axis] + middle * image.Spacing[axis];
  }
  const std::int64_t frames = image.Sizes[TiffImage::Frames];
  for (std::int64_t frame = 0; frames > 1 && frame < frames; ++frame)
  {
    volume.Times.push_back(static_cast<double>(frame) * image.TimeStep);
  }
  volume.Grid.Unit = FindLengthUnit(image.Unit);
  if (!image.Unit.empty() && volume.Grid.Unit == LengthUnit::Unknown)
  {
    image.AddNote("the unit of lengths, " + image.Unit + ", is not kept");
  }
  volume.LeftOut = image.Notes;
}

Result<OpenedVolume> OpenTiff(FileSystem& files, const VolumeName& name, const VolumeChoice& choice)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto stack, SliceFiles::Find(files, name.Path));
  const std::vector<std::string>& paths = stack.Paths;
  TiffFiles read(files, paths.front());
  ISOSURFACE_ASSIGN_OR_RETURN(const auto images, TiffImages::Read(read, name, choice));
  ISOSURFACE_ASSIGN_OR_RETURN(auto image, images.Choose());
  TiffPlanes planes(read, choice);
  const bool isOfOneFile = std::all_of(image.Runs.begin(), image.Runs.end(),
    [](const TiffImage::Run& run) { return run.File.empty(); });
  if (paths.size() > 1 && isOfOneFile)
  {
    ISOSURFACE_RETURN_IF_ERROR(planes.TakeStack(paths, image));
    if (!image.Unit.empty() && image.Spacing[2] == 1)
    {
      image.AddNote("the distance of slices in several files is not told, and taken as 1");
    }
  }
  else
  {
    ISOSURFACE_RETURN_IF_ERROR(planes.TakeImage(image));
    if (paths.size() > 1)
    {
      image.AddNote(
        "the image is that of " + paths.front() + ", whose OME-XML says which files it is in");
    }
  }
  planes.ChooseLevel();
  ISOSURFACE_ASSIGN_OR_RETURN(auto parts, MakeChannels(files, planes, image));
  OpenedVolume volume;
  volume.Grid.Extent = {};
  ISOSURFACE_RETURN_IF_ERROR(TakeVolumeArrays(std::move(parts), choice.Arrays, volume));
  if (!stack.LeftOut.empty())
  {
    image.AddNote(stack.LeftOut);
  }
  if (!images.GetNotes().empty())
  {
    image.AddNote(images.GetNotes());
  }
  TakePlaceAndNotes(planes, image, volume);
  volume.Files = planes.GetPaths();
  if (!images.GetMetadata().empty())
  {
    volume.Files.push_back(images.GetMetadata());
  }
  return volume;
}

Result<std::vector<VolumeListing>> ListTiff(FileSystem& files, const VolumeName& name)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto stack, SliceFiles::Find(files, name.Path));
  const std::vector<std::string>& paths = stack.Paths;
  TiffFiles read(files, paths.front());
  const VolumeChoice choice;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto images, TiffImages::Read(read, name, choice));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto own, read.Open(paths.front()));
  const TiffFormat& format = own->Contents.Formats.front();
  std::vector<VolumeListing> list;
  for (const TiffImage& image : images.Get())
  {
    std::string shape;
    for (const TiffImage::Axis axis : { TiffImage::Frames, TiffImage::Channels, TiffImage::Slices })
    {
      const bool isShown = image.Sizes[axis] > 1 || axis == TiffImage::Slices;
      shape += isShown ? std::to_string(image.Sizes[axis]) + " x " : "";
    }
    const bool isKnown = image.Width > 0 && image.Height > 0;
    shape += std::to_string(isKnown ? image.Height : format.Height) + " x " +
      std::to_string(isKnown ? image.Width : format.Width);
    list.push_back({ images.GetName(list.size()), shape,
      image.Type.empty() ? GetValueTypeName(format.Type) : image.Type, image.DescribeSizes() });
  }
  return list;
}

} // namespace

/**
 * A volume of TIFF:
 *
 *     file           the first image of the file; the pages are slices, channels and time steps as
 *                    OME-XML, ImageJ or tifffile say in the descriptions, or all of them slices
 *     file:NAME      another image, by its name, identifier or number (from 0)
 *     folder, a*.tif a slice a page of all files (SliceFiles); or, if the first one has OME-XML that
 *                    names others, its first image
 *
 * Channels are arrays, samples of a pixel components. Of a pyramid (tag SubIFDs) it may be a coarser
 * level, whose slices are as far apart as its rows (of a level with half of the rows every second page)
 * unless few would be left.
 */
extern "C" const FormatFunctions IsosurfaceTiffFormat;
const FormatFunctions IsosurfaceTiffFormat = { OpenTiff, ListTiff };

} // namespace isosurface
