// SPDX-License-Identifier: BSD-3-Clause
#include "Source/RawSource.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <sys/mman.h>

namespace isosurface
{
namespace
{

/// Memory straight from the system, which gets it back at once: slabs are large, and a heap would
/// keep some of them.
class PageBuffer
{
public:
  explicit PageBuffer(std::size_t size)
    : Size(size)
    , Pages(::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0))
  {
  }
  PageBuffer(const PageBuffer&) = delete;
  PageBuffer& operator=(const PageBuffer&) = delete;
  ~PageBuffer()
  {
    if (this->IsValid())
    {
      ::munmap(this->Pages, this->Size);
    }
  }
  bool IsValid() const { return this->Pages != MAP_FAILED; }
  std::uint8_t* GetData() const { return static_cast<std::uint8_t*>(this->Pages); }
  std::size_t GetSize() const { return this->Size; }

private:
  std::size_t Size;
  void* Pages;
};

} // namespace

/// Memory of slabs that nobody needs any more. The next ones are mostly as large: to get new memory
/// for them costs as much as to copy their samples.
class RawSource::IdleBuffers
{
public:
  /// A buffer of at least `size` bytes, hardly larger. Takes no new memory before the idle one is
  /// given back. Null without memory.
  std::unique_ptr<PageBuffer> Take(std::size_t size)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    const auto fits = [size](const std::unique_ptr<PageBuffer>& buffer)
    { return buffer->GetSize() >= size && buffer->GetSize() - size <= size / 16; };
    const auto found = std::find_if(this->Buffers.begin(), this->Buffers.end(), fits);
    if (found != this->Buffers.end())
    {
      std::unique_ptr<PageBuffer> buffer = std::move(*found);
      this->Buffers.erase(found);
      return buffer;
    }
    this->Buffers.clear();
    auto buffer = std::make_unique<PageBuffer>(size);
    return buffer->IsValid() ? std::move(buffer) : nullptr;
  }

  void Return(std::unique_ptr<PageBuffer> buffer)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    try
    {
      this->Buffers.push_back(std::move(buffer));
    }
    catch (const std::bad_alloc&)
    {
      // It is freed rather than kept.
    }
  }

private:
  std::mutex Mutex;
  std::vector<std::unique_ptr<PageBuffer>> Buffers;
};

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

RawSource::RawSource(std::unique_ptr<RandomAccessFile> file, std::uint64_t offset,
  const Index3& size, ValueType type, bool isBigEndian, std::uint64_t heldBytes)
  : File(std::move(file))
  , Offset(offset)
  , Box{ { 0, 0, 0 }, size }
  , Type(type)
  , IsBigEndian(isBigEndian)
  , HeldBytes(heldBytes)
  , Idle(std::make_shared<IdleBuffers>())
{
}

std::uint64_t RawSource::GetReadBytes(const VertexBox& box) const
{
  return static_cast<std::uint64_t>(box.GetNumberOfVertices()) * GetValueSize(this->Type);
}

Result<SampleSlab> RawSource::Read(const VertexBox& box)
{
  const auto bytes = static_cast<std::size_t>(this->GetReadBytes(box));
  std::unique_ptr<PageBuffer> buffer = this->Idle->Take(bytes);
  if (!buffer)
  {
    return Status(StatusCode::IoError,
      this->File->GetPath() + ": cannot read: no memory for " + std::to_string(bytes) +
        " bytes: " + std::strerror(errno));
  }
  const std::shared_ptr<PageBuffer> samples(buffer.release(),
    [idle = this->Idle](PageBuffer* used) { idle->Return(std::unique_ptr<PageBuffer>(used)); });
  ISOSURFACE_RETURN_IF_ERROR(this->ReadSamples(box, samples->GetData()));
  if (this->IsBigEndian)
  {
    DispatchValueType(this->Type,
      [&](auto zero)
      {
        using T = decltype(zero);
        SwapBytes<T>(samples->GetData(), bytes / sizeof(T));
      });
  }
  SampleSlab slab;
  SampleView view;
  view.Type = this->Type;
  view.First = samples->GetData();
  view.Available = box;
  view.Box = box;
  const Index3 size = box.GetSize();
  view.Stride = { 1, size[0], size[0] * size[1] };
  slab.Arrays = { view };
  slab.Owner = samples;
  return slab;
}

Status RawSource::ReadSamples(const VertexBox& box, std::uint8_t* to) const
{
  const Index3 whole = this->Box.GetSize();
  const Index3 size = box.GetSize();
  const std::size_t valueSize = GetValueSize(this->Type);
  // As many rows and slices at once as follow each other in the file.
  const std::int64_t rows = size[0] == whole[0] ? size[1] : 1;
  const std::int64_t slices = rows == whole[1] ? size[2] : 1;
  const std::size_t bytes = static_cast<std::size_t>(size[0] * rows * slices) * valueSize;
  for (std::int64_t k = box.Low[2]; k < box.High[2]; k += slices)
  {
    for (std::int64_t j = box.Low[1]; j < box.High[1]; j += rows)
    {
      const auto sample = static_cast<std::uint64_t>(box.Low[0] + whole[0] * (j + whole[1] * k));
      ISOSURFACE_RETURN_IF_ERROR(this->File->Read(this->Offset + sample * valueSize, bytes, to));
      to += bytes;
    }
  }
  return Status::Ok();
}

} // namespace isosurface
