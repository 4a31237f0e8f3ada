// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffPlanes.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace isosurface
{

std::string TiffFiles::FindPath(const std::string& name) const
{
  return name.empty() ? this->Own : FindBeside(this->Own, name);
}

Result<TiffFiles::ReadFile*> TiffFiles::Open(const std::string& path)
{
  auto found = this->Read.find(path);
  if (found == this->Read.end())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto file, TiffFile::Open(this->Files, path));
    ISOSURFACE_ASSIGN_OR_RETURN(auto contents, file->FindPages());
    constexpr std::size_t most = 256;
    for (auto at = this->Read.begin(); this->Read.size() >= most && at != this->Read.end();)
    {
      at = at->first == this->Own ? std::next(at) : this->Read.erase(at);
    }
    found = this->Read.emplace(path, ReadFile{ std::move(file), std::move(contents) }).first;
  }
  return &found->second;
}

Status TiffFiles::CheckStack(ReadFile& read)
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
namespace
{

constexpr std::uint64_t MaximumBytes = std::uint64_t{ 1 } << 62;

/// Of a level, if the pages are as many: pages may be larger than the stack is high.
constexpr std::int64_t FewestSlices = 32;
constexpr std::int64_t MaximumChannels = 1024;

/// The name of a type of OME-XML here.
std::string FindTypeName(const std::string& type)
{
  return type == "float" ? "float32" : type == "double" ? "float64" : type;
}

} // namespace

Result<std::shared_ptr<TiffArray>> TiffArray::Open(FileSystem& files,
  std::shared_ptr<const std::vector<std::string>> paths, std::vector<TiffSlice> slices,
  const TiffFormat& format, bool isOffset)
{
  // Sizes of boxes are products that must not wrap.
  const std::uint64_t pageBytes =
    static_cast<std::uint64_t>(format.Width * format.Height) * format.GetPixelBytes();
  if (slices.size() > MaximumBytes / pageBytes)
  {
    return Status(
      StatusCode::Unsupported, paths->front() + ": a stack of 2^62 bytes or more is not supported");
  }
  std::shared_ptr<TiffArray> array(
    new TiffArray(files, std::move(paths), std::move(slices), format, isOffset));
  const TiffSlice& first = array->Slices.front();
  ISOSURFACE_RETURN_IF_ERROR(array->OpenFile(first.File));
  ISOSURFACE_RETURN_IF_ERROR(array->Opened->TakeFormat(first.Page));
  array->ScratchBytes = array->Opened->GetScratchBytes();
  const std::array<std::int64_t, 2>& unit = array->Opened->GetUnit();
  array->Chunk = { 1, unit[1], unit[0] };
  for (std::size_t axis = 1; axis < 3; ++axis)
  {
    constexpr std::int64_t block = 32;
    array->Chunk[axis] =
      std::min(array->Chunk[axis] * ((block - 1) / array->Chunk[axis] + 1), array->Shape[axis]);
  }
  if (format.Components > 1)
  {
    array->Chunk.push_back(format.Components);
  }
  return array;
}

TiffArray::TiffArray(FileSystem& files, std::shared_ptr<const std::vector<std::string>> paths,
  std::vector<TiffSlice> slices, const TiffFormat& format, bool isOffset)
  : Files(files)
  , Paths(std::move(paths))
  , Slices(std::move(slices))
  , Format(format)
  , IsOffset(isOffset && format.Type == ValueType::UInt16)
  , Shape{ static_cast<std::int64_t>(this->Slices.size()), format.Height, format.Width }
{
  if (format.Components > 1)
  {
    this->Shape.push_back(format.Components);
  }
}

Status TiffArray::OpenFile(std::size_t number)
{
  if (!this->Opened || this->OpenNumber != number)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto file, TiffFile::Open(this->Files, (*this->Paths)[number]));
    file->SetFormat(this->Format);
    this->Opened = std::move(file);
    this->OpenNumber = number;
  }
  return Status::Ok();
}

std::uint64_t TiffArray::GetHeldBytes() const
{
  return this->ScratchBytes + this->Slices.size() * sizeof(TiffSlice);
}

Status TiffArray::Read(const Numbers& low, const Numbers& size, std::uint8_t* to)
{
  const TiffRectangle rectangle = { low[2], low[2] + size[2], low[1], low[1] + size[1] };
  const std::size_t sliceBytes =
    static_cast<std::size_t>(size[1] * size[2]) * this->Format.GetPixelBytes();
  for (std::int64_t k = low[0]; k < low[0] + size[0]; ++k)
  {
    const TiffSlice& slice = this->Slices[static_cast<std::size_t>(k)];
    ISOSURFACE_RETURN_IF_ERROR(this->OpenFile(slice.File));
    ISOSURFACE_RETURN_IF_ERROR(this->Opened->Read(slice.Page, rectangle, to));
    if (this->IsOffset)
    {
      auto* const samples = reinterpret_cast<std::uint16_t*>(to);
      std::transform(samples, samples + sliceBytes / sizeof(*samples), samples,
        [](std::uint16_t sample) { return static_cast<std::uint16_t>(sample ^ 0x8000U); });
    }
    to += sliceBytes;
  }
  return Status::Ok();
}

Status TiffPlanes::TakeImage(TiffImage& image)
{
  const std::array<std::int64_t, 3>& sizes = image.Sizes;
  if (sizes[TiffImage::Channels] > MaximumChannels ||
    (sizes[TiffImage::Slices] == 1 && sizes[TiffImage::Channels] > 1 &&
      sizes[TiffImage::Frames] > 1))
  {
    return this->Files.MakeError(StatusCode::Unsupported,
      "its images are of " + image.DescribeSizes() +
        (sizes[TiffImage::Channels] > MaximumChannels ? "" : ": there is no stack of slices"));
  }
  // As many as there are pages, whatever the description says.
  std::map<std::pair<std::int64_t, std::int64_t>, TiffSlice> found;
  const auto count = [this](const std::string& file) -> Result<std::int64_t>
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto read, this->Files.Open(this->Files.FindPath(file)));
    return static_cast<std::int64_t>(read->Contents.Pages.size());
  };
  const auto visit = [&](const std::array<std::int64_t, 3>& place, const std::string& file,
                       std::int64_t page) -> Status
  {
    if (place[TiffImage::Frames] != static_cast<std::int64_t>(this->Choice.Step))
    {
      return Status::Ok();
    }
    const std::string path = this->Files.FindPath(file);
    ISOSURFACE_ASSIGN_OR_RETURN(const auto read, this->Files.Open(path));
    const std::vector<TiffPage>& pages = read->Contents.Pages;
    if (page >= static_cast<std::int64_t>(pages.size()))
    {
      return this->Files.MakeError(StatusCode::Corrupt,
        "truncated: its description names page " + std::to_string(page + 1) + " of " + path +
          ", which has " + std::to_string(pages.size()));
    }
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto slice, this->MakeSlice(*read, path, pages[static_cast<std::size_t>(page)]));
    found[{ place[TiffImage::Channels], place[TiffImage::Slices] }] = slice;
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(image.Visit(this->Files.GetOwn(), count, visit));
  for (const auto& [place, slice] : found)
  {
    Slices& slices = this->Channels[place.first];
    if (place.second == static_cast<std::int64_t>(slices.size()))
    {
      slices.push_back(slice);
    }
  }
  return this->CheckImage(image);
}

/// A channel has all slices or, in a file of a set, none.
Status TiffPlanes::CheckImage(TiffImage& image)
{
  for (const auto& [channel, slices] : this->Channels)
  {
    if (static_cast<std::int64_t>(slices.size()) != image.Sizes[TiffImage::Slices])
    {
      return this->Files.MakeError(StatusCode::Corrupt,
        "truncated: slice " + std::to_string(slices.size() + 1) + " of " +
          std::to_string(image.Sizes[TiffImage::Slices]) + " of channel " +
          std::to_string(channel) + " is in no page");
    }
  }
  if (!this->Format)
  {
    return this->Files.MakeError(
      StatusCode::Corrupt, "truncated: no page has time step " + std::to_string(this->Choice.Step));
  }
  std::string missing;
  for (std::int64_t channel = 0; channel < image.Sizes[TiffImage::Channels]; ++channel)
  {
    missing += this->Channels.count(channel) > 0
      ? ""
      : (missing.empty() ? "" : ", ") + std::to_string(channel);
  }
  if (!missing.empty())
  {
    image.AddNote("channels whose pages are in other files are left out: " + missing);
  }
  const std::string type = GetValueTypeName(this->Format->Type);
  if (const std::string said = FindTypeName(image.Type); !said.empty() && said != type)
  {
    image.AddNote("samples are " + type + ", although OME-XML says " + said);
  }
  const bool hasOtherSize = image.Width > 0 && image.Height > 0 &&
    (image.Width != this->Format->Width || image.Height != this->Format->Height);
  return hasOtherSize
    ? this->Files.MakeError(StatusCode::Corrupt,
        "its pages are of " + std::to_string(this->Format->Width) + " x " +
          std::to_string(this->Format->Height) + " pixels, its OME-XML speaks of " +
          std::to_string(image.Width) + " x " + std::to_string(image.Height))
    : Status::Ok();
}

std::size_t TiffPlanes::NumberFile(const std::string& path)
{
  const auto [found, isNew] = this->Numbers.emplace(path, this->Paths.size());
  if (isNew)
  {
    this->Paths.push_back(path);
  }
  return found->second;
}

Result<TiffSlice> TiffPlanes::MakeSlice(
  TiffFiles::ReadFile& read, const std::string& path, const TiffPage& page)
{
  const Status status = page.Format < 0 ? read.File->TakeFormat(page) : Status::Ok();
  ISOSURFACE_RETURN_IF_ERROR(status);
  if (page.Format < 0)
  {
    return read.File->MakeErrorOf(
      page, StatusCode::Unsupported, "its file has pages of too many sizes and types");
  }
  const TiffFormat& format = read.Contents.Formats[static_cast<std::size_t>(page.Format)];
  if (!this->Format)
  {
    this->Format = format;
    this->Levels = read.File->GetNumberOfLevels();
  }
  if (!(*this->Format == format))
  {
    return path != this->Files.GetOwn()
      ? Status(StatusCode::Unsupported,
          path + ": its size or type differs from that of " + this->Files.GetOwn())
      : read.File->MakeErrorOf(
          page, StatusCode::Unsupported, "its size or type differs from that of the pages before");
  }
  // Levels that not all files have are none.
  this->Levels = std::min(this->Levels, read.File->GetNumberOfLevels());
  const TiffSlice slice = { this->NumberFile(path), page };
  if (this->Choice.Vertices > 0)
  {
    std::vector<std::uint64_t>& smaller = this->Smaller[{ slice.File, page.Directory }];
    smaller.resize(this->Levels);
    for (std::size_t level = 0; level < this->Levels; ++level)
    {
      smaller[level] = read.File->GetPageOfLevel(page, level + 1).Directory;
    }
  }
  return slice;
}

Status TiffPlanes::TakeStack(const std::vector<std::string>& paths, TiffImage& image)
{
  Slices& slices = this->Channels[0];
  for (const std::string& path : paths)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto read, this->Files.Open(path));
    ISOSURFACE_RETURN_IF_ERROR(TiffFiles::CheckStack(*read));
    for (const TiffPage& page : read->Contents.Pages)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto slice, this->MakeSlice(*read, path, page));
      slices.push_back(slice);
    }
    if (path == this->Files.GetOwn() && read->Contents.Pages.size() > 1 &&
      image.Sizes[TiffImage::Slices] != image.GetNumberOfPlanes())
    {
      return this->Files.MakeError(StatusCode::Unsupported,
        "its images are of " + image.DescribeSizes() +
          ": in a stack of several files, pages are slices alone; read it by itself");
    }
  }
  image.Sizes = { static_cast<std::int64_t>(slices.size()), 1, 1 };
  image.ChannelNames.clear();
  return Status::Ok();
}

TiffSlice TiffPlanes::FindSmaller(TiffSlice slice, std::size_t level) const
{
  slice.Page.Directory =
    this->Smaller.find({ slice.File, slice.Page.Directory })->second[level - 1];
  return slice;
}

std::optional<TiffFormat> TiffPlanes::FindFormatOfLevel(std::size_t level) const
{
  const TiffSlice slice = this->FindSmaller(this->Channels.begin()->second.front(), level);
  const auto file = TiffFile::Open(this->Files.GetFileSystem(), this->Paths[slice.File]);
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

void TiffPlanes::ChooseLevel()
{
  const auto pages = static_cast<std::int64_t>(this->Channels.begin()->second.size());
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
    this->Steps[1] = static_cast<double>(this->Format->Height) / static_cast<double>(format.Height);
    every = std::clamp<std::int64_t>(
      std::lround(this->Steps[1]), 1, std::max<std::int64_t>(1, pages / FewestSlices));
    this->Steps[2] = static_cast<double>(every);
    ++this->Level;
  }
  if (this->Level == 0)
  {
    return;
  }
  this->Format = format;
  for (auto& [channel, slices] : this->Channels)
  {
    Slices chosen;
    for (std::size_t page = 0; page < slices.size(); page += static_cast<std::size_t>(every))
    {
      chosen.push_back(this->FindSmaller(slices[page], this->Level));
    }
    slices = std::move(chosen);
  }
}

} // namespace isosurface
