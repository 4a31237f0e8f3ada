// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PageBuffer_h
#define isosurface_PageBuffer_h

#include "Base/Status.h"
#include "Source/SlabSource.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

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

/**
 * Page buffers that nobody needs any more. The next slabs are mostly as large, and to get new
 * memory for them costs as much as to copy their samples. Safe for use by any number of threads.
 */
class PageBufferPool : public std::enable_shared_from_this<PageBufferPool>
{
public:
  /// A buffer of at least `size` bytes, hardly larger, that comes back here when it is let go. Its
  /// bytes are arbitrary. Idle buffers that do not fit are given back to the system before new
  /// memory is taken. OutOfMemory as Create.
  Result<std::shared_ptr<PageBuffer>> Take(std::uint64_t size);

private:
  void Return(std::shared_ptr<PageBuffer> buffer);

  std::mutex Mutex;
  std::vector<std::shared_ptr<PageBuffer>> Idle;
};

/// The slab of one array whose samples of a box stand in a buffer without gaps, x fastest.
SampleSlab MakeSlab(
  ValueType type, const VertexBox& box, std::shared_ptr<const PageBuffer> samples);

} // namespace isosurface

#endif
