// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffImages.h"

#include "Formats/Source/FormatFunctions.h"
#include "Formats/Source/SliceFiles.h"
#include "Formats/Source/TextFields.h"
#include "Formats/Tiff/OmeXml.h"
#include "Formats/Tiff/TiffDescription.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <utility>

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

} // namespace

Result<TiffImages> TiffImages::Read(
  TiffFiles& files, const VolumeName& name, const VolumeChoice& choice)
{
  TiffImages images(files, name, choice);
  ISOSURFACE_RETURN_IF_ERROR(images.FindImages());
  return images;
}

Status TiffImages::FindImages()
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

std::string TiffImages::GetPageAxes() const
{
  const std::string& axes = this->Choice.Axes;
  const std::size_t rows = axes.rfind("yx");
  return rows == std::string::npos ? axes : axes.substr(0, rows);
}

Status TiffImages::ReadOme(const std::string& text)
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

Result<std::string> TiffImages::ReadMetadata(const std::string& path)
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

std::string TiffImages::GetName(std::size_t number) const
{
  const std::string& name = this->Images[number].Name;
  const auto same = std::count_if(this->Images.begin(), this->Images.end(),
    [&name](const TiffImage& image) { return image.Name == name || image.Id == name; });
  return name.empty() || same > 1 || ParseInteger(name) ? std::to_string(number) : name;
}

Result<TiffImage> TiffImages::Choose() const
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

} // namespace isosurface
