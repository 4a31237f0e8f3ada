// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffSource.h"

#include "Ground/Volume/PageBuffer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::uint64_t MaximumBytes = std::uint64_t{ 1 } << 62;
/// Of a level, if the pages are as many: pages may be larger than the stack is high.
constexpr std::int64_t FewestSlices = 32;

} // namespace

Result<std::unique_ptr<TiffSource>> TiffSource::Open(
  FileSystem& files, const std::vector<std::string>& paths, std::int64_t vertices)
{
  if (paths.empty())
  {
    return Status(StatusCode::InvalidArgument, "a stack without files");
  }
  std::unique_ptr<TiffSource> source(new TiffSource(files, paths));
  ISOSURFACE_RETURN_IF_ERROR(source->FindSlices());
  ISOSURFACE_RETURN_IF_ERROR(source->ChooseLevel(vertices));
  ISOSURFACE_RETURN_IF_ERROR(source->FindBox());
  return source;
}

Status TiffSource::FindSlices()
{
  for (std::size_t number = 0; number < this->Paths.size(); ++number)
  {
    auto file = TiffFile::Open(this->Files, this->Paths[number]);
    ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
    const auto pages = (*file)->FindPages();
    ISOSURFACE_RETURN_IF_ERROR(pages.GetStatus());
    if (number > 0 && !((*file)->GetFormat() == this->Format))
    {
      return Status(StatusCode::Unsupported,
        this->Paths[number] + ": its size or type differs from that of " + this->Paths[0]);
    }
    this->Format = (*file)->GetFormat();
    this->ScratchBytes = std::max(this->ScratchBytes, (*file)->GetScratchBytes());
    for (const TiffPage& page : *pages)
    {
      this->Slices.push_back({ number, page });
    }
    // Levels that not all files have are none.
    const std::size_t levels = (*file)->GetNumberOfLevels();
    this->SmallerSlices.resize(number == 0 ? levels : std::min(levels, this->SmallerSlices.size()));
    for (std::size_t level = 0; level < this->SmallerSlices.size(); ++level)
    {
      for (std::size_t page = 0; page < pages->size(); ++page)
      {
        this->SmallerSlices[level].push_back({ number, (*file)->GetPageOfLevel(page, level + 1) });
      }
    }
    this->Opened = std::move(*file);
    this->OpenNumber = number;
  }
  return Status::Ok();
}

std::optional<TiffFormat> TiffSource::FindFormatOfLevel(std::size_t level)
{
  if (!this->OpenFile(0).IsOk() ||
    !this->Opened->TakeFormat(this->SmallerSlices[level - 1].front().Page).IsOk())
  {
    return std::nullopt;
  }
  const TiffFormat& found = this->Opened->GetFormat();
  const bool isSmaller = found.Type == this->Format.Type && found.Width <= this->Format.Width &&
    found.Height <= this->Format.Height;
  return isSmaller ? std::optional(found) : std::nullopt;
}

Status TiffSource::ChooseLevel(std::int64_t vertices)
{
  const auto pages = static_cast<std::int64_t>(this->Slices.size());
  TiffFormat format = this->Format;
  std::int64_t every = 1; // of the pages, one is taken
  const auto isLarge = [&]
  {
    return static_cast<double>(format.Width) * static_cast<double>(format.Height) *
      std::ceil(static_cast<double>(pages) / static_cast<double>(every)) >
      static_cast<double>(vertices);
  };
  std::size_t level = 0;
  while (vertices > 0 && level < this->SmallerSlices.size() && isLarge())
  {
    const auto coarser = this->FindFormatOfLevel(level + 1);
    if (!coarser)
    {
      this->Opened = nullptr;
      break; // this one is there all the same
    }
    format = *coarser;
    this->Steps[0] = static_cast<double>(this->Format.Width) / static_cast<double>(format.Width);
    this->Steps[1] = static_cast<double>(this->Format.Height) / static_cast<double>(format.Height);
    every = std::clamp<std::int64_t>(
      std::lround(this->Steps[1]), 1, std::max<std::int64_t>(1, pages / FewestSlices));
    this->Steps[2] = static_cast<double>(every);
    ++level;
  }
  if (level > 0)
  {
    this->Level = static_cast<int>(level);
    this->Slices.clear();
    const std::vector<Slice>& ofLevel = this->SmallerSlices[level - 1];
    for (std::int64_t page = 0; page < pages; page += every)
    {
      this->Slices.push_back(ofLevel[static_cast<std::size_t>(page)]);
    }
    this->Format = format;
  }
  this->SmallerSlices = {};
  if (this->Opened && level == 0)
  {
    return Status::Ok(); // no other format was taken
  }
  ISOSURFACE_RETURN_IF_ERROR(this->OpenFile(0));
  ISOSURFACE_RETURN_IF_ERROR(this->Opened->TakeFormat(this->Slices.front().Page));
  this->ScratchBytes = this->Opened->GetScratchBytes();
  return Status::Ok();
}

Status TiffSource::FindBox()
{
  // Sizes of boxes are products that must not wrap.
  const std::uint64_t pageBytes =
    static_cast<std::uint64_t>(this->Format.Width * this->Format.Height) *
    GetValueSize(this->Format.Type);
  if (this->Slices.size() > MaximumBytes / pageBytes)
  {
    return Status(
      StatusCode::Unsupported, this->Paths[0] + ": a stack of 2^62 bytes or more is not supported");
  }
  this->Box.High = { this->Format.Width, this->Format.Height,
    static_cast<std::int64_t>(this->Slices.size()) };
  const std::array<std::int64_t, 2>& unit = this->Opened->GetUnit();
  for (std::size_t axis = 0; axis < 2; ++axis)
  {
    constexpr std::int64_t block = 32;
    this->Chunk[axis] = std::min(unit[axis] * ((block - 1) / unit[axis] + 1), this->Box.High[axis]);
  }
  return Status::Ok();
}

Status TiffSource::OpenFile(std::size_t number)
{
  if (!this->Opened || this->OpenNumber != number)
  {
    auto file = TiffFile::Open(this->Files, this->Paths[number]);
    ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
    (*file)->SetFormat(this->Format);
    this->Opened = std::move(*file);
    this->OpenNumber = number;
  }
  return Status::Ok();
}

std::uint64_t TiffSource::GetReadBytes(const VertexBox& box) const
{
  return static_cast<std::uint64_t>(box.GetNumberOfVertices()) * GetValueSize(this->Format.Type);
}

std::uint64_t TiffSource::GetHeldBytes() const
{
  return this->ScratchBytes + this->Slices.size() * sizeof(Slice);
}

Result<BoxSamples> TiffSource::Read(const VertexBox& box)
{
  auto samples = PageBuffer::Create(this->GetReadBytes(box));
  if (!samples.IsOk())
  {
    return Status(samples.GetStatus().GetCode(),
      this->Paths.front() + ": cannot read: " + samples.GetStatus().GetMessage());
  }
  const TiffRectangle rectangle = { box.Low[0], box.High[0], box.Low[1], box.High[1] };
  const Index3 size = box.GetSize();
  const std::size_t sliceBytes =
    static_cast<std::size_t>(size[0] * size[1]) * GetValueSize(this->Format.Type);
  std::uint8_t* to = (*samples)->GetData();
  for (std::int64_t k = box.Low[2]; k < box.High[2]; ++k)
  {
    const Slice& slice = this->Slices[static_cast<std::size_t>(k)];
    ISOSURFACE_RETURN_IF_ERROR(this->OpenFile(slice.File));
    ISOSURFACE_RETURN_IF_ERROR(this->Opened->Read(slice.Page, rectangle, to));
    to += sliceBytes;
  }
  return MakeBoxSamples(this->Format.Type, box, std::move(*samples));
}

} // namespace isosurface
