// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffSource.h"

#include "Ground/Volume/PageBuffer.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::uint64_t MaximumBytes = std::uint64_t{ 1 } << 62;

} // namespace

Result<std::unique_ptr<TiffSource>> TiffSource::Open(
  FileSystem& files, const std::vector<std::string>& paths)
{
  if (paths.empty())
  {
    return Status(StatusCode::InvalidArgument, "a stack without files");
  }
  std::unique_ptr<TiffSource> source(new TiffSource(files, paths));
  ISOSURFACE_RETURN_IF_ERROR(source->FindSlices());
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
    this->Opened = std::move(*file);
    this->OpenNumber = number;
  }
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
