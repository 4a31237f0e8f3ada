// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffVolume.h"

#include "Formats/Source/ArraySource.h"
#include "Formats/Source/TextFields.h"
#include "Formats/Tiff/OmeXml.h"
#include "Formats/Tiff/TiffArray.h"
#include "Formats/Tiff/TiffDescription.h"
#include "Formats/Tiff/TiffImage.h"
#include "Formats/Tiff/TiffStack.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

/// Of a level, if the pages are as many: pages may be larger than the stack is high.
constexpr std::int64_t FewestSlices = 32;
constexpr std::uint64_t MaximumMetadata = std::uint64_t{ 64 } << 20;
const char* const ArrayName = "Tiff Scalars";

/// A file of a volume, whose directories were read.
struct ReadFile
{
  std::unique_ptr<TiffFile> File;
  TiffContents Contents;
};

Result<ReadFile> ReadDirectories(FileSystem& files, const std::string& path)
{
  auto file = TiffFile::Open(files, path);
  ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
  auto contents = (*file)->FindPages();
  ISOSURFACE_RETURN_IF_ERROR(contents.GetStatus());
  return ReadFile{ std::move(*file), std::move(*contents) };
}

/// Leaves out pages that are smaller images or masks of others, like the thumbnails of microscopes. All
/// others must have the format of the first one, and numbers that do not descend.
Status CheckStack(ReadFile& read)
{
  std::vector<TiffPage>& pages = read.Contents.Pages;
  const int format = pages.front().Format;
  pages.erase(
    std::remove_if(pages.begin(), pages.end(),
      [format](const TiffPage& page) { return page.IsOfAnother && page.Format != format; }),
    pages.end());
  for (const TiffPage& page : pages)
  {
    if (page.Format != format)
    {
      const Status status = page.Format < 0 ? read.File->TakeFormat(page) : Status::Ok();
      return !status.IsOk() ? status
                            : read.File->MakeErrorOf(page, StatusCode::Unsupported,
                                "its size or type differs from that of the pages before");
    }
  }
  return read.Contents.PageNumbers;
}

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

class TiffReader
{
public:
  TiffReader(FileSystem& files, const VolumeName& name, const VolumeChoice& choice)
    : Files(files)
    , Name(name)
    , Choice(choice)
  {
  }

  Result<OpenedVolume> Open()
  {
    const auto paths = FindTiffStack(this->Files, this->Name.Path);
    ISOSURFACE_RETURN_IF_ERROR(paths.GetStatus());
    ISOSURFACE_RETURN_IF_ERROR(this->FindImages(paths->front()));
    ISOSURFACE_RETURN_IF_ERROR(this->ChooseImage());
    if (paths->size() > 1 && this->IsOfOneFile())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->TakeStack(*paths));
    }
    else
    {
      if (paths->size() > 1)
      {
        this->Image.AddNote(
          "the image is that of " + paths->front() + ", whose OME-XML says which files it is in");
      }
      ISOSURFACE_RETURN_IF_ERROR(this->TakePlanes());
    }
    ISOSURFACE_RETURN_IF_ERROR(this->ChooseLevel());
    return this->MakeVolume();
  }

  Result<std::vector<VolumeListing>> List()
  {
    const auto paths = FindTiffStack(this->Files, this->Name.Path);
    ISOSURFACE_RETURN_IF_ERROR(paths.GetStatus());
    ISOSURFACE_RETURN_IF_ERROR(this->FindImages(paths->front()));
    const std::vector<TiffFormat>& formats = this->Read.begin()->second.Contents.Formats;
    std::vector<VolumeListing> list;
    for (std::size_t number = 0; number < this->Images.size(); ++number)
    {
      const TiffImage& image = this->Images[number];
      std::string shape;
      for (const TiffImage::Axis axis :
        { TiffImage::Frames, TiffImage::Channels, TiffImage::Slices })
      {
        const bool isShown = image.Sizes[axis] > 1 || axis == TiffImage::Slices;
        shape += isShown ? std::to_string(image.Sizes[axis]) + " x " : "";
      }
      const bool isKnown = image.Width > 0 && image.Height > 0;
      shape += std::to_string(isKnown ? image.Height : formats.front().Height) + " x " +
        std::to_string(isKnown ? image.Width : formats.front().Width);
      list.push_back({ this->NameImage(number), shape,
        image.Type.empty() ? GetValueTypeName(formats.front().Type) : image.Type,
        image.DescribeSizes() });
    }
    return list;
  }

private:
  Status MakeError(StatusCode code, const std::string& reason) const
  {
    return Status(code, this->Own + ": cannot be read: " + reason);
  }

  /// Adds the path and the reason to an error that is a sentence without a file.
  Status AddPath(const Status& status) const
  {
    return this->MakeError(status.GetCode(), status.GetMessage());
  }

  /// The path of a file that a description names; of its own, if the name is empty.
  std::string FindPath(const std::string& file) const
  {
    return file.empty() ? this->Own
                        : (std::filesystem::path(this->Own).parent_path() / file).string();
  }

  Status FindImages(const std::string& path)
  {
    this->Own = path;
    auto read = ReadDirectories(this->Files, path);
    ISOSURFACE_RETURN_IF_ERROR(read.GetStatus());
    const std::string text = read->Contents.Description;
    if (OmeXml::IsOme(text))
    {
      ISOSURFACE_RETURN_IF_ERROR(this->ReadOme(text));
    }
    else if (const auto properties = TiffDescription::FindImageJ(text))
    {
      ISOSURFACE_RETURN_IF_ERROR(CheckStack(*read));
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
      auto images = TiffDescription::MakeShaped(read->Contents, this->PageAxes());
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
      ISOSURFACE_RETURN_IF_ERROR(CheckStack(*read));
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
      else if (!program.empty())
      {
        image.AddNote(program + " describes the page in its own way, which is not read");
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
    this->Read.emplace(path, std::move(*read));
    return Status::Ok();
  }

  /// What --axes says of the pages: without y and x.
  std::string PageAxes() const
  {
    const std::string& axes = this->Choice.Axes;
    const std::size_t rows = axes.rfind("yx");
    return rows == std::string::npos ? axes : axes.substr(0, rows);
  }

  Status ReadOme(const std::string& text)
  {
    const std::string name = std::filesystem::path(this->Own).filename().string();
    auto ome = OmeXml::Parse(text, name);
    if (ome.IsOk() && !ome->MetadataFile.empty())
    {
      const auto other = this->ReadMetadata(this->FindPath(ome->MetadataFile));
      ISOSURFACE_RETURN_IF_ERROR(other.GetStatus());
      ome = OmeXml::Parse(*other, name);
      if (ome.IsOk() && !ome->MetadataFile.empty())
      {
        return this->MakeError(StatusCode::Unsupported,
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
    if (IsTiffName(path))
    {
      const auto read = ReadDirectories(this->Files, path);
      ISOSURFACE_RETURN_IF_ERROR(read.GetStatus());
      return read->Contents.Description;
    }
    const auto file = this->Files.OpenForReading(path);
    ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
    if ((*file)->GetSize() > MaximumMetadata)
    {
      return Status(StatusCode::Unsupported, path + ": OME-XML of more than 64 MiB is not read");
    }
    std::string text(static_cast<std::size_t>((*file)->GetSize()), '\0');
    ISOSURFACE_RETURN_IF_ERROR((*file)->Read(0, text.size(), text.data()));
    this->Metadata = path;
    return text;
  }

  /// What names an image behind a colon: its name, if no other has it and it is no number.
  std::string NameImage(std::size_t number) const
  {
    const std::string& name = this->Images[number].Name;
    const auto same = std::count_if(this->Images.begin(), this->Images.end(),
      [&name](const TiffImage& image) { return image.Name == name || image.Id == name; });
    return name.empty() || same > 1 || ParseInteger(name) ? std::to_string(number) : name;
  }

  Status ChooseImage()
  {
    std::size_t chosen = 0;
    const std::string& within = this->Name.Within;
    for (std::size_t number = this->Images.size(); number-- > 0 && !within.empty();)
    {
      const bool isIt = within == this->Images[number].Id || within == std::to_string(number) ||
        within == this->NameImage(number);
      chosen = isIt ? number + 1 : chosen;
    }
    std::string known;
    constexpr std::size_t most = 20; // in a message
    for (std::size_t number = 0; number < std::min(most, this->Images.size()); ++number)
    {
      known += (known.empty() ? "" : ", ") + this->NameImage(number);
    }
    known += this->Images.size() > most ? ", ..." : "";
    if (!within.empty() && chosen == 0)
    {
      return Status(StatusCode::NotFound,
        this->Name.GetText() + ": cannot be read: there is no such image; it has " + known);
    }
    this->Image = this->Images[chosen == 0 ? 0 : chosen - 1];
    if (!this->Image.Fault.IsOk())
    {
      return this->AddPath(this->Image.Fault);
    }
    if (within.empty() && this->Images.size() > 1)
    {
      this->Image.AddNote("the first of " + std::to_string(this->Images.size()) +
        " images is read; they are named behind a colon: " + known);
    }
    const std::int64_t frames = this->Image.Sizes[TiffImage::Frames];
    if (frames > MaximumTimeSteps)
    {
      return this->MakeError(
        StatusCode::Unsupported, "it has " + std::to_string(frames) + " time steps");
    }
    if (this->Choice.Step >= static_cast<std::uint64_t>(frames))
    {
      return Status(StatusCode::InvalidArgument,
        this->Own + ": has " + std::to_string(frames) + " time steps, and none of number " +
          std::to_string(this->Choice.Step));
    }
    return Status::Ok();
  }

  bool IsOfOneFile() const
  {
    return std::all_of(this->Image.Runs.begin(), this->Image.Runs.end(),
      [](const TiffImage::Run& run) { return run.File.empty(); });
  }

  /// The number of a file among those of the samples.
  std::size_t NumberFile(const std::string& path)
  {
    const auto [found, isNew] = this->Numbers.emplace(path, this->Paths.size());
    if (isNew)
    {
      this->Paths.push_back(path);
    }
    return found->second;
  }

  /// Adds a page to the slices of a channel, whose smaller images are added to those of the levels.
  Status AddSlice(ReadFile& read, const std::string& path, const TiffPage& page, TiffSlice& slice)
  {
    const Status status = page.Format < 0 ? read.File->TakeFormat(page) : Status::Ok();
    ISOSURFACE_RETURN_IF_ERROR(status);
    const TiffFormat& format = read.Contents.Formats[static_cast<std::size_t>(page.Format)];
    if (!this->Format)
    {
      this->Format = format;
      this->Levels = read.File->GetNumberOfLevels();
    }
    if (!(*this->Format == format))
    {
      return path != this->Own ? Status(StatusCode::Unsupported,
                                   path + ": its size or type differs from that of " + this->Own)
                               : read.File->MakeErrorOf(page, StatusCode::Unsupported,
                                   "its size or type differs from that of the pages before");
    }
    this->Levels = std::min(this->Levels, read.File->GetNumberOfLevels());
    slice.File = this->NumberFile(path);
    slice.Page = page;
    if (this->Choice.Vertices > 0)
    {
      std::vector<std::uint64_t>& smaller = this->Smaller[{ slice.File, page.Directory }];
      smaller.resize(this->Levels);
      for (std::size_t level = 0; level < this->Levels; ++level)
      {
        smaller[level] = read.File->GetPageOfLevel(page, level + 1).Directory;
      }
    }
    return Status::Ok();
  }

  Result<ReadFile*> OpenFile(const std::string& path)
  {
    auto found = this->Read.find(path);
    if (found == this->Read.end())
    {
      auto read = ReadDirectories(this->Files, path);
      ISOSURFACE_RETURN_IF_ERROR(read.GetStatus());
      constexpr std::size_t most = 256; // that stay open
      for (auto at = this->Read.begin(); this->Read.size() >= most && at != this->Read.end();)
      {
        at = at->first == this->Own ? std::next(at) : this->Read.erase(at);
      }
      found = this->Read.emplace(path, std::move(*read)).first;
    }
    return &found->second;
  }

  /// Finds the pages of the time step that the image says.
  Status TakePlanes()
  {
    if (this->Image.Sizes[TiffImage::Slices] == 1 && this->Image.Sizes[TiffImage::Channels] > 1 &&
      this->Image.Sizes[TiffImage::Frames] > 1)
    {
      return this->MakeError(StatusCode::Unsupported,
        "its images are of " + this->Image.DescribeSizes() + ": there is no stack of slices");
    }
    const auto slices = static_cast<std::size_t>(this->Image.Sizes[TiffImage::Slices]);
    this->Channels.assign(static_cast<std::size_t>(this->Image.Sizes[TiffImage::Channels]),
      std::vector<std::optional<TiffSlice>>(slices));
    const auto count = [this](const std::string& file) -> Result<std::int64_t>
    {
      const auto read = this->OpenFile(this->FindPath(file));
      ISOSURFACE_RETURN_IF_ERROR(read.GetStatus());
      return static_cast<std::int64_t>((*read)->Contents.Pages.size());
    };
    const auto visit = [this](const std::array<std::int64_t, 3>& place, const std::string& file,
                         std::int64_t page) -> Status
    {
      if (place[TiffImage::Frames] != static_cast<std::int64_t>(this->Choice.Step))
      {
        return Status::Ok();
      }
      const std::string path = this->FindPath(file);
      const auto read = this->OpenFile(path);
      ISOSURFACE_RETURN_IF_ERROR(read.GetStatus());
      const std::vector<TiffPage>& pages = (*read)->Contents.Pages;
      if (page >= static_cast<std::int64_t>(pages.size()))
      {
        return this->MakeError(StatusCode::Corrupt,
          "truncated: its description names page " + std::to_string(page + 1) + " of " + path +
            ", which has " + std::to_string(pages.size()));
      }
      TiffSlice slice;
      ISOSURFACE_RETURN_IF_ERROR(
        this->AddSlice(**read, path, pages[static_cast<std::size_t>(page)], slice));
      this->Channels[static_cast<std::size_t>(place[TiffImage::Channels])]
                    [static_cast<std::size_t>(place[TiffImage::Slices])] = slice;
      return Status::Ok();
    };
    ISOSURFACE_RETURN_IF_ERROR(this->Image.Visit(this->Own, count, visit));
    return this->CheckPlanes();
  }

  /// A channel has all slices or, in a file of a set, none.
  Status CheckPlanes()
  {
    std::string missing;
    for (std::size_t channel = 0; channel < this->Channels.size(); ++channel)
    {
      const auto& slices = this->Channels[channel];
      const auto lost = std::find(slices.begin(), slices.end(), std::nullopt);
      const bool isWhole = lost == slices.end();
      const bool isAbsent = std::all_of(
        slices.begin(), slices.end(), [](const auto& slice) { return !slice.has_value(); });
      if (!isWhole && !isAbsent)
      {
        return this->MakeError(StatusCode::Corrupt,
          "truncated: slice " + std::to_string(lost - slices.begin() + 1) + " of " +
            std::to_string(slices.size()) + " of channel " + std::to_string(channel) +
            " is in no page");
      }
      missing += isAbsent ? (missing.empty() ? "" : ", ") + std::to_string(channel) : "";
    }
    if (!this->Format)
    {
      return this->MakeError(StatusCode::Corrupt,
        "truncated: no page has time step " + std::to_string(this->Choice.Step));
    }
    if (!missing.empty())
    {
      this->Image.AddNote("channels whose pages are in other files are left out: " + missing);
    }
    const bool hasOtherSize = this->Image.Width > 0 && this->Image.Height > 0 &&
      (this->Image.Width != this->Format->Width || this->Image.Height != this->Format->Height);
    if (hasOtherSize)
    {
      return this->MakeError(StatusCode::Corrupt,
        "its pages are of " + std::to_string(this->Format->Width) + " x " +
          std::to_string(this->Format->Height) + " pixels, its OME-XML speaks of " +
          std::to_string(this->Image.Width) + " x " + std::to_string(this->Image.Height));
    }
    return Status::Ok();
  }

  /// The pages of several files, one after the other, as slices.
  Status TakeStack(const std::vector<std::string>& paths)
  {
    this->Channels.assign(1, {});
    for (const std::string& path : paths)
    {
      const auto read = this->OpenFile(path);
      ISOSURFACE_RETURN_IF_ERROR(read.GetStatus());
      ISOSURFACE_RETURN_IF_ERROR(CheckStack(**read));
      for (const TiffPage& page : (*read)->Contents.Pages)
      {
        TiffSlice slice;
        ISOSURFACE_RETURN_IF_ERROR(this->AddSlice(**read, path, page, slice));
        this->Channels[0].push_back(slice);
      }
      if (path == this->Own && (*read)->Contents.Pages.size() > 1 &&
        this->Image.Sizes[TiffImage::Slices] != this->Image.GetNumberOfPlanes())
      {
        return this->MakeError(StatusCode::Unsupported,
          "its images are of " + this->Image.DescribeSizes() +
            ": in a stack of several files, pages are slices alone; read it by itself");
      }
    }
    this->Image.Sizes = { static_cast<std::int64_t>(this->Channels[0].size()), 1, 1 };
    this->Image.ChannelNames.clear();
    if (!this->Image.Unit.empty() && this->Image.Spacing[2] == 1)
    {
      this->Image.AddNote("the distance of slices in several files is not told, and taken as 1");
    }
    return Status::Ok();
  }

  /// The format of a level, from 1; nothing if its first page cannot be one of a smaller image.
  std::optional<TiffFormat> FindFormatOfLevel(std::size_t level)
  {
    const TiffSlice slice = this->FindSmaller(*this->FindFirst(), level);
    const auto file = TiffFile::Open(this->Files, this->Paths[slice.File]);
    if (!file.IsOk() || !(*file)->TakeFormat(slice.Page).IsOk())
    {
      return std::nullopt;
    }
    const TiffFormat& found = (*file)->GetFormat();
    const bool isSmaller = found.Type == this->Format->Type && found.Width <= this->Format->Width &&
      found.Height <= this->Format->Height && found.Components == this->Format->Components &&
      found.Planes == this->Format->Planes;
    return isSmaller ? std::optional(found) : std::nullopt;
  }

  const std::optional<TiffSlice>& FindFirst() const
  {
    return std::find_if(this->Channels.begin(), this->Channels.end(),
      [](const auto& slices) { return slices.front().has_value(); })
      ->front();
  }

  TiffSlice FindSmaller(TiffSlice slice, std::size_t level) const
  {
    slice.Page.Directory =
      this->Smaller.find({ slice.File, slice.Page.Directory })->second[level - 1];
    return slice;
  }

  /// Goes to the finest level of at most so many vertices, or the coarsest.
  Status ChooseLevel()
  {
    const auto pages = this->Image.Sizes[TiffImage::Slices];
    TiffFormat format = *this->Format;
    std::int64_t every = 1; // of the pages, one is taken
    const auto isLarge = [&]
    {
      return static_cast<double>(format.Width) * static_cast<double>(format.Height) *
        std::ceil(static_cast<double>(pages) / static_cast<double>(every)) >
        static_cast<double>(this->Choice.Vertices);
    };
    while (this->Choice.Vertices > 0 && this->Level < this->Levels && isLarge())
    {
      const auto coarser = this->FindFormatOfLevel(this->Level + 1);
      if (!coarser)
      {
        break; // this one is there all the same
      }
      format = *coarser;
      this->Steps[0] = static_cast<double>(this->Format->Width) / static_cast<double>(format.Width);
      this->Steps[1] =
        static_cast<double>(this->Format->Height) / static_cast<double>(format.Height);
      every = std::clamp<std::int64_t>(
        std::lround(this->Steps[1]), 1, std::max<std::int64_t>(1, pages / FewestSlices));
      this->Steps[2] = static_cast<double>(every);
      ++this->Level;
    }
    this->LevelFormat = format;
    return Status::Ok();
  }

  /// The slices of a channel at the level.
  std::vector<TiffSlice> FindSlices(const std::vector<std::optional<TiffSlice>>& channel) const
  {
    std::vector<TiffSlice> slices;
    const auto every = static_cast<std::size_t>(this->Steps[2]);
    for (std::size_t page = 0; page < channel.size(); page += every)
    {
      slices.push_back(
        this->Level == 0 ? *channel[page] : this->FindSmaller(*channel[page], this->Level));
    }
    return slices;
  }

  /// What a channel is called, among those before it.
  std::string NameChannel(std::size_t channel, const std::vector<ArrayPart>& parts) const
  {
    const std::vector<std::string>& names = this->Image.ChannelNames;
    const std::string name = channel < names.size() ? names[channel] : "";
    const bool isNew = std::none_of(
      parts.begin(), parts.end(), [&name](const ArrayPart& part) { return part.Name == name; });
    return this->Channels.size() == 1 && this->Format->Planes == 1 ? ArrayName
      : !name.empty() && isNew                                     ? name
                               : ArrayName + std::string(" ") + std::to_string(channel);
  }

  Result<OpenedVolume> MakeVolume()
  {
    const auto paths = std::make_shared<const std::vector<std::string>>(this->Paths);
    const auto planes = static_cast<std::size_t>(this->Format->Planes);
    std::vector<ArrayPart> parts;
    for (std::size_t channel = 0; channel < this->Channels.size() * planes; ++channel)
    {
      if (!this->Channels[channel / planes].front())
      {
        continue;
      }
      std::vector<TiffSlice> slices = this->FindSlices(this->Channels[channel / planes]);
      for (TiffSlice& slice : slices)
      {
        slice.Page.Plane = static_cast<std::uint16_t>(channel % planes);
      }
      auto array = TiffArray::Open(
        this->Files, paths, std::move(slices), this->LevelFormat, this->Image.IsOffset);
      ISOSURFACE_RETURN_IF_ERROR(array.GetStatus());
      const bool hasComponents = this->LevelFormat.Components > 1;
      const auto axes = ArrayAxes::Parse(hasComponents ? "zyxc" : "zyx", hasComponents ? 4 : 3);
      auto made = MakeParts(this->NameChannel(channel, parts), std::move(*array), *axes, 0);
      ISOSURFACE_RETURN_IF_ERROR(made.GetStatus());
      parts.insert(parts.end(), made->begin(), made->end());
    }
    OpenedVolume volume;
    volume.Grid.Extent = {};
    ISOSURFACE_RETURN_IF_ERROR(TakeParts(std::move(parts), this->Choice.Arrays, volume));
    for (ArrayDescription& array : volume.Arrays)
    {
      array.Unit = this->Image.SampleUnit;
    }
    volume.Level = static_cast<int>(this->Level);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      volume.Grid.Spacing[axis] = this->Image.Spacing[axis] * this->Steps[axis];
      // A sample of a level is in the middle of those of the page that it stands for.
      const double middle = axis < 2 ? (this->Steps[axis] - 1) / 2 : 0;
      volume.Grid.Origin[axis] = this->Image.Origin[axis] + middle * this->Image.Spacing[axis];
    }
    const std::int64_t frames = this->Image.Sizes[TiffImage::Frames];
    for (std::int64_t frame = 0; frames > 1 && frame < frames; ++frame)
    {
      volume.Times.push_back(static_cast<double>(frame) * this->Image.TimeStep);
    }
    if (!this->Image.Unit.empty())
    {
      this->Image.AddNote("the unit of lengths, " + this->Image.Unit + ", is not kept");
    }
    if (!this->Notes.empty())
    {
      this->Image.AddNote(this->Notes);
    }
    volume.LeftOut = this->Image.Notes;
    volume.Files = this->Paths;
    if (!this->Metadata.empty())
    {
      volume.Files.push_back(this->Metadata);
    }
    return volume;
  }

  FileSystem& Files;
  const VolumeName& Name;
  const VolumeChoice& Choice;
  std::string Own;      ///< the first file, whose description tells
  std::string Metadata; ///< a file of OME-XML alone; perhaps empty
  std::string Notes;    ///< of the tags of the first page
  std::map<std::string, ReadFile> Read;
  std::vector<TiffImage> Images;
  bool IsShaped = false; ///< whether tifffile says what they are, whose axes may be told otherwise
  TiffImage Image;       ///< the one that is opened
  std::vector<std::string> Paths;
  std::map<std::string, std::size_t> Numbers; ///< of Paths
  std::vector<std::vector<std::optional<TiffSlice>>> Channels;
  std::optional<TiffFormat> Format; ///< of the pages
  std::size_t Levels = 0;           ///< that all pages have
  /// The directories of the smaller images of pages, by file and directory, if a level is chosen.
  std::map<std::pair<std::size_t, std::uint64_t>, std::vector<std::uint64_t>> Smaller;
  std::size_t Level = 0; ///< of the pyramid; 0: the pages themselves
  TiffFormat LevelFormat;
  std::array<double, 3> Steps{ 1, 1,
    1 }; ///< how many samples of the pages are between two of the level
};

Result<OpenedVolume> OpenTiff(FileSystem& files, const VolumeName& name, const VolumeChoice& choice)
{
  return TiffReader(files, name, choice).Open();
}

Result<std::vector<VolumeListing>> ListTiff(FileSystem& files, const VolumeName& name)
{
  return TiffReader(files, name, {}).List();
}

} // namespace

const FormatFunctions IsosurfaceTiffFormat = { OpenTiff, ListTiff };

} // namespace isosurface
