// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/RawSource.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

template <typename T>
void SwapBytes(std::uint8_t* bytes, std::size_t samples)
{
  for (std::size_t sample = 0; sample < samples; ++sample)
  {
    std::reverse(bytes + sample * sizeof(T), bytes + (sample + 1) * sizeof(T));
  }
}

} // namespace

RawSource::RawSource(std::unique_ptr<RandomAccessFile> file, const Index3& size, ValueType type,
  bool isBigEndian, std::uint64_t heldBytes)
  : File(std::move(file))
  , Box{ { 0, 0, 0 }, size }
  , Type(type)
  , IsBigEndian(isBigEndian)
  , HeldBytes(heldBytes)
  , Pool(std::make_shared<PageBufferPool>())
{
}

std::uint64_t RawSource::GetReadBytes(const VertexBox& box) const
{
  const std::size_t valueSize = GetValueSize(this->Type);
  const Index3 size = box.GetSize();
  const std::int64_t slices = std::max<std::int64_t>(1, size[2]);
  return static_cast<std::uint64_t>(
           ChooseSlicePitch(box, valueSize) * (slices - 1) + size[0] * size[1]) *
    valueSize;
}

std::optional<Index3> RawSource::GetChunk() const
{
  if (this->HeldBytes > 0)
  {
    return std::nullopt; // a stream
  }
  // Whole rows, which follow each other in the file.
  constexpr std::int64_t rows = 32;
  const Index3 size = this->Box.GetSize();
  return Index3{ size[0], std::min(rows, size[1]), std::min(rows, size[2]) };
}

void RawSource::Prefetch(const VertexBox& box) const
{
  const Index3 whole = this->Box.GetSize();
  const std::uint64_t slice =
    static_cast<std::uint64_t>(whole[0] * whole[1]) * GetValueSize(this->Type);
  this->File->Prefetch(static_cast<std::uint64_t>(box.Low[2]) * slice,
    static_cast<std::uint64_t>(box.GetSize()[2]) * slice);
}

Result<BoxSamples> RawSource::Read(const VertexBox& box)
{
  auto samples = this->Pool->Take(this->GetReadBytes(box));
  if (!samples.IsOk())
  {
    return Status(samples.GetStatus().GetCode(),
      this->File->GetPath() + ": cannot read: " + samples.GetStatus().GetMessage());
  }
  std::uint8_t* bytes = (*samples)->GetData();
  const std::int64_t pitch = ChooseSlicePitch(box, GetValueSize(this->Type));
  const std::int64_t slice = box.GetSize()[0] * box.GetSize()[1];
  if (pitch == slice)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->ReadSamples(box, bytes));
  }
  else
  {
    VertexBox part = box;
    for (part.Low[2] = box.Low[2]; part.Low[2] < box.High[2]; part.Low[2] = part.High[2])
    {
      part.High[2] = part.Low[2] + 1;
      const auto first = static_cast<std::size_t>((part.Low[2] - box.Low[2]) * pitch);
      ISOSURFACE_RETURN_IF_ERROR(this->ReadSamples(part, bytes + first * GetValueSize(this->Type)));
    }
  }
  return MakeBoxSamples(this->Type, box, std::move(*samples), pitch);
}

Status RawSource::ReadSamples(const VertexBox& box, std::uint8_t* to) const
{
  const Index3 whole = this->Box.GetSize();
  const Index3 size = box.GetSize();
  const std::size_t valueSize = GetValueSize(this->Type);
  // Reads as many rows and slices at once as are contiguous in the file.
  const std::int64_t rows = size[0] == whole[0] ? size[1] : 1;
  const std::int64_t slices = rows == whole[1] ? size[2] : 1;
  const std::size_t bytes = static_cast<std::size_t>(size[0] * rows * slices) * valueSize;
  for (std::int64_t k = box.Low[2]; k < box.High[2]; k += slices)
  {
    for (std::int64_t j = box.Low[1]; j < box.High[1]; j += rows)
    {
      const auto sample = static_cast<std::uint64_t>(box.Low[0] + whole[0] * (j + whole[1] * k));
      ISOSURFACE_RETURN_IF_ERROR(this->File->Read(sample * valueSize, bytes, to));
      if (this->IsBigEndian)
      {
        DispatchValueType(
          this->Type, [&](auto zero) { SwapBytes<decltype(zero)>(to, bytes / valueSize); });
      }
      to += bytes;
    }
  }
  return Status::Ok();
}

} // namespace isosurface
