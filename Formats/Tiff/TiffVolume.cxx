// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/ArraySource.h"
#include "Formats/Source/FormatFunctions.h"
#include "Formats/Source/SliceFiles.h"
#include "Formats/Source/TextFields.h"
#include "Formats/Tiff/OmeXml.h"
#include "Formats/Tiff/TiffDescription.h"
#include "Formats/Tiff/TiffImage.h"
#include "Formats/Tiff/TiffPlanes.h"
#include "Ground/Volume/VolumeName.h"
#include "Ground/Volume/VolumeOpener.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

constexpr std::uint64_t MaximumMetadata = std::uint64_t{ 64 } << 20;

/// Tells a resolution of length, unless it is that of a screen.
void NoteResolution(const TiffContents& contents, TiffImage& image)
{
  const double resolution = contents.XResolution;
  const bool isLength = contents.ResolutionUnit == 2 || contents.ResolutionUnit == 3;
  if (isLength && resolution > 1 && resolution != 72 && resolution != 96)
  {
    std::array<char, 128> text{};
    std::snprintf(text.data(), text.size(),
      "its resolution, %.7g x %.7g pixels per %s, is not used as spacing (--spacing gives it)",
      resolution, contents.YResolution, contents.ResolutionUnit == 2 ? "inch" : "cm");
    image.AddNote(text.data());
  }
}

/// The images of a TIFF file, as the description of its first page tells them: OME-XML, which may be in
/// another file, ImageJ or tifffile; or one image of which each page is a slice.
class TiffImages
{
public:
  /// `files` must outlive the images.
  static Result<TiffImages> Read(
    TiffFiles& files, const VolumeName& name, const VolumeChoice& choice)
  {
    TiffImages images(files, name, choice);
    ISOSURFACE_RETURN_IF_ERROR(images.FindImages());
    return images;
  }

  const std::vector<TiffImage>& Get() const { return this->Images; }
  /// What names an image behind a colon: its name, if no other has it and it is no number.
  std::string GetName(std::size_t number) const
  {
    const std::string& name = this->Images[number].Name;
    const auto same = std::count_if(this->Images.begin(), this->Images.end(),
      [&name](const TiffImage& image) { return image.Name == name || image.Id == name; });
    return name.empty() || same > 1 || ParseInteger(name) ? std::to_string(number) : name;
  }

  /// The image that the name of the volume chooses, of which the time step is there.
  Result<TiffImage> Choose() const
  {
    std::size_t chosen = 0;
    const std::string& within = this->Name.Within;
    for (std::size_t number = this->Images.size(); number-- > 0 && !within.empty();)
    {
      const bool isIt = within == this->Images[number].Id || within == std::to_string(number) ||
        within == this->GetName(number);
      chosen = isIt ? number + 1 : chosen;
    }
    std::string known;
    constexpr std::size_t most = 20; // in a message
    for (std::size_t number = 0; number < std::min(most, this->Images.size()); ++number)
    {
      known += (known.empty() ? "" : ", ") + this->GetName(number);
    }
    known += this->Images.size() > most ? ", ..." : "";
    if (!within.empty() && chosen == 0)
    {
      return Status(StatusCode::NotFound,
        this->Name.GetText() + ": cannot be read: there is no such image; it has " + known);
    }
    TiffImage image = this->Images[chosen == 0 ? 0 : chosen - 1];
    if (!image.Fault.IsOk())
    {
      return this->AddPath(image.Fault);
    }
    if (within.empty() && this->Images.size() > 1)
    {
      image.AddNote("the first of " + std::to_string(this->Images.size()) +
        " images is read; they are named behind a colon: " + known);
    }
    const std::int64_t frames = image.Sizes[TiffImage::Frames];
    if (frames > MaximumTimeSteps)
    {
      return this->Files.MakeError(
        StatusCode::Unsupported, "it has " + std::to_string(frames) + " time steps");
    }
    if (this->Choice.Step >= static_cast<std::uint64_t>(frames))
    {
      return Status(StatusCode::InvalidArgument,
        this->Files.GetOwn() + ": has " + std::to_string(frames) +
          " time steps, and none of number " + std::to_string(this->Choice.Step));
    }
    return image;
  }

  /// What other tags of the first page tell; perhaps empty.
  const std::string& GetNotes() const { return this->Notes; }
  /// A file of OME-XML alone; perhaps empty.
  const std::string& GetMetadata() const { return this->Metadata; }

private:
  TiffImages(TiffFiles& files, const VolumeName& name, const VolumeChoice& choice)
    : Files(files)
    , Name(name)
    , Choice(choice)
  {
  }

  Status FindImages()
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto read, this->Files.Open(this->Files.GetOwn()));
    const std::string text = read->Contents.Description;
    if (OmeXml::IsOme(text))
    {
      ISOSURFACE_RETURN_IF_ERROR(this->ReadOme(text));
    }
    else if (const auto properties = TiffDescription::FindImageJ(text))
    {
      ISOSURFACE_RETURN_IF_ERROR(TiffFiles::CheckStack(*read));
      auto image = TiffDescription::MakeImageJ(
        *properties, read->Contents, static_cast<std::int64_t>(read->Contents.Pages.size()));
      if (!image.IsOk())
      {
        return this->AddPath(image.GetStatus());
      }
      this->Images = { std::move(*image) };
    }
    else if (!read->Contents.Shapes.empty() && read->Contents.Shapes.front().first == 0)
    {
      auto images = TiffDescription::MakeShaped(read->Contents, this->GetPageAxes());
      if (!images.IsOk())
      {
        return this->AddPath(images.GetStatus());
      }
      this->Images = std::move(*images);
      this->IsShaped = true;
      NoteResolution(read->Contents, this->Images.front());
    }
    else
    {
      ISOSURFACE_RETURN_IF_ERROR(TiffFiles::CheckStack(*read));
      TiffImage image;
      const auto pages = static_cast<std::int64_t>(read->Contents.Pages.size());
      image.Sizes[TiffImage::Slices] = pages;
      image.Runs = { { "", 0, 0, pages } };
      const std::string& program = read->Contents.Program;
      if (!program.empty() && pages > 1)
      {
        image.AddNote(program +
          " describes the pages in its own way, which is not read: they are "
          "taken as slices, in their order");
      }
      else if (program == "MetaMorph" || program == "NIH Image")
      {
        return this->Files.MakeError(StatusCode::Unsupported,
          program + " keeps all slices of a stack in one page, in its own way");
      }
      NoteResolution(read->Contents, image);
      this->Images = { std::move(image) };
    }
    if (!this->Choice.Axes.empty() && !this->Choice.IsRecorded && !this->IsShaped)
    {
      return Status(StatusCode::InvalidArgument,
        this->Name.GetText() + ": cannot be read with the axes \"" + this->Choice.Axes +
          "\": those of TIFF files are given");
    }
    this->Notes = read->Contents.Notes;
    return Status::Ok();
  }

  /// What --axes says of the pages: without y and x.
  std::string GetPageAxes() const
  {
    const std::string& axes = this->Choice.Axes;
    const std::size_t rows = axes.rfind("yx");
    return rows == std::string::npos ? axes : axes.substr(0, rows);
  }

  Status ReadOme(const std::string& text)
  {
    const std::string name = std::filesystem::path(this->Files.GetOwn()).filename().string();
    auto ome = OmeXml::Parse(text, name);
    if (ome.IsOk() && !ome->MetadataFile.empty())
    {
      ISOSURFACE_ASSIGN_OR_RETURN(
        const auto other, this->ReadMetadata(this->Files.FindPath(ome->MetadataFile)));
      ome = OmeXml::Parse(other, name);
      if (ome.IsOk() && !ome->MetadataFile.empty())
      {
        return this->Files.MakeError(StatusCode::Unsupported,
          "the OME-XML that it names, " + ome->MetadataFile + ", is in another file again");
      }
    }
    if (!ome.IsOk())
    {
      return this->AddPath(ome.GetStatus());
    }
    this->Images = std::move(ome->Images);
    for (TiffImage& image : this->Images)
    {
      if (image.Runs.empty() && this->Images.size() == 1)
      {
        image.Runs = { { "", 0, 0, -1 } };
      }
      image.TakePagesAsSlices();
    }
    return Status::Ok();
  }

  /// The OME-XML of another file: of a TIFF file, or text.
  Result<std::string> ReadMetadata(const std::string& path)
  {
    if (SliceFiles::FindKind({ std::filesystem::path(path).filename().string() }) == "TIFF")
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto read, this->Files.Open(path));
      return read->Contents.Description;
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto file, this->Files.GetFileSystem().OpenForReading(path));
    if (file->GetSize() > MaximumMetadata)
    {
      return Status(StatusCode::Unsupported, path + ": OME-XML of more than 64 MiB is not read");
    }
    std::string text(static_cast<std::size_t>(file->GetSize()), '\0');
    ISOSURFACE_RETURN_IF_ERROR(file->Read(0, text.size(), text.data()));
    this->Metadata = path;
    return text;
  }

  /// Adds the path and the reason to an error that is a sentence without a file.
  Status AddPath(const Status& status) const
  {
    return this->Files.MakeError(status.GetCode(), status.GetMessage());
  }

  TiffFiles& Files;
  const VolumeName& Name;
  const VolumeChoice& Choice;
  std::vector<TiffImage> Images;
  bool IsShaped = false; ///< whether tifffile says what they are, whose axes may be told otherwise
  std::string Notes;
  std::string Metadata;
};

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
