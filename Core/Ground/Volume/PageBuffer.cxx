// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/PageBuffer.h"

#include "Ground/Base/HugePages.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <string>
#include <utility>

#include <sys/mman.h>

namespace isosurface
{

Result<std::shared_ptr<PageBuffer>> PageBuffer::Create(std::uint64_t size)
{
  const auto mapped = static_cast<std::size_t>(std::max<std::uint64_t>(1, size));
  void* pages = ::mmap(nullptr, mapped, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (pages == MAP_FAILED)
  {
    return Status(StatusCode::OutOfMemory,
      "no memory for " + std::to_string(size) + " bytes: " + std::strerror(errno));
  }
  // The rows of a block are far apart in a large box: each would be on another small page.
  AdviseHugePages(pages, mapped);
  return std::shared_ptr<PageBuffer>(new PageBuffer(pages, mapped));
}

PageBuffer::~PageBuffer()
{
  ::munmap(this->Pages, this->Size);
}

Result<std::shared_ptr<PageBuffer>> PageBufferPool::Take(std::uint64_t size)
{
  std::shared_ptr<PageBuffer> buffer;
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    const auto found = std::find_if(this->Idle.begin(), this->Idle.end(),
      [size](const std::shared_ptr<PageBuffer>& idle)
      { return idle->GetSize() >= size && idle->GetSize() - size <= size / 16; });
    if (found != this->Idle.end())
    {
      buffer = std::move(*found);
      this->Idle.erase(found);
    }
    else
    {
      this->Idle.clear();
    }
  }
  if (!buffer)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(buffer, PageBuffer::Create(size));
  }
  PageBuffer* const pages = buffer.get();
  return std::shared_ptr<PageBuffer>(pages,
    [pool = this->shared_from_this(), buffer = std::move(buffer)](PageBuffer*) mutable
    { pool->Return(std::move(buffer)); });
}

void PageBufferPool::Return(std::shared_ptr<PageBuffer> buffer)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  try
  {
    this->Idle.push_back(std::move(buffer));
  }
  catch (const std::bad_alloc&)
  {
    // Then the buffer is freed.
  }
}

std::int64_t ChooseSlicePitch(const VertexBox& box, std::size_t valueSize)
{
  // An odd number of lines, and not a power of two of them from row to row.
  constexpr std::int64_t gap = 33 * 64;
  constexpr std::int64_t page = 4096;
  const auto size = static_cast<std::int64_t>(valueSize);
  const std::int64_t slice = box.GetSize()[0] * box.GetSize()[1];
  return slice + (slice * size % page == 0 ? gap / size : 0);
}

BoxSamples MakeBoxSamples(ValueType type, const VertexBox& box,
  std::shared_ptr<const PageBuffer> samples, std::int64_t slicePitch)
{
  SampleView view;
  view.Type = type;
  view.First = samples->GetData();
  view.Available = box;
  view.Box = box;
  const Index3 size = box.GetSize();
  view.Stride = { 1, size[0], slicePitch > 0 ? slicePitch : size[0] * size[1] };
  BoxSamples result;
  result.Arrays = { view };
  result.Owner = std::move(samples);
  return result;
}

} // namespace isosurface
