// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffArray.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::uint64_t MaximumBytes = std::uint64_t{ 1 } << 62;

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

} // namespace isosurface
