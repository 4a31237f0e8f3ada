// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PageBuffer_h
#define isosurface_PageBuffer_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/BoxSource.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace isosurface
{

/// Memory allocated by the system instead of the heap, which would not give large slabs back at
/// once. Its bytes are zero.
class PageBuffer
{
public:
  /// Errors: OutOfMemory, with the system's reason.
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
 * A pool of unused page buffers. The next box usually has the same size, and new memory for it
 * would cost as much as copying its samples. Any number of threads may use a pool.
 */
class PageBufferPool : public std::enable_shared_from_this<PageBufferPool>
{
public:
  /// Returns a buffer of `size` bytes, or slightly more, with undefined content. When it is
  /// released it returns to the pool. If no unused buffer fits, all are freed before a new one is
  /// created. Errors: as Create().
  Result<std::shared_ptr<PageBuffer>> Take(std::uint64_t size);

private:
  void Return(std::shared_ptr<PageBuffer> buffer);

  std::mutex Mutex;
  std::vector<std::shared_ptr<PageBuffer>> Idle;
};

/// The samples of one array in a box. They are in a buffer, x fastest; a slice begins
/// `slicePitch` samples after the one before it, without a gap if this is 0.
BoxSamples MakeBoxSamples(ValueType type, const VertexBox& box,
  std::shared_ptr<const PageBuffer> samples, std::int64_t slicePitch = 0);

/// The distance of the slices of a box in samples, with which the rows of a block that lie above
/// each other are in different sets of the processor's caches: where slices take a multiple of 4096
/// bytes, there is a gap between them.
std::int64_t ChooseSlicePitch(const VertexBox& box, std::size_t valueSize);

} // namespace isosurface

#endif
