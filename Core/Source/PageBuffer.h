// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PageBuffer_h
#define isosurface_PageBuffer_h

#include "Base/Status.h"
#include "Source/SlabSource.h"

#include <cstddef>
#include <cstdint>
#include <memory>

namespace isosurface
{

/// Memory straight from the system, which gets it back at once: slabs are large, and a heap would
/// keep some of them. Its bytes are zero.
class PageBuffer
{
public:
  /// OutOfMemory, with the system's reason, if there is none.
  static Result<std::shared_ptr<PageBuffer>> Create(std::uint64_t size);
  PageBuffer(const PageBuffer&) = delete;
  PageBuffer& operator=(const PageBuffer&) = delete;
  ~PageBuffer();

  std::uint8_t* GetData() const { return static_cast<std::uint8_t*>(this->Pages); }
  std::size_t GetSize() const { return this->Size; }

private:
  PageBuffer(void* pages, std::size_t size)
    : Pages(pages)
    , Size(size)
  {
  }

  void* Pages;
  std::size_t Size;
};

/// The slab of one array whose samples of a box stand in a buffer without gaps, x fastest.
SampleSlab MakeSlab(
  ValueType type, const VertexBox& box, std::shared_ptr<const PageBuffer> samples);

} // namespace isosurface

#endif
