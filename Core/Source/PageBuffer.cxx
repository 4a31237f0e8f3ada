// SPDX-License-Identifier: BSD-3-Clause
#include "Source/PageBuffer.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
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
  return std::shared_ptr<PageBuffer>(new PageBuffer(pages, mapped));
}

PageBuffer::~PageBuffer()
{
  ::munmap(this->Pages, this->Size);
}

SampleSlab MakeSlab(ValueType type, const VertexBox& box, std::shared_ptr<const PageBuffer> samples)
{
  SampleView view;
  view.Type = type;
  view.First = samples->GetData();
  view.Available = box;
  view.Box = box;
  const Index3 size = box.GetSize();
  view.Stride = { 1, size[0], size[0] * size[1] };
  SampleSlab slab;
  slab.Arrays = { view };
  slab.Owner = std::move(samples);
  return slab;
}

} // namespace isosurface
