// SPDX-License-Identifier: BSD-3-Clause
#include "AllocationCounter.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace
{

std::atomic<std::ptrdiff_t> Current(0);
std::atomic<std::ptrdiff_t> Peak(0);

} // namespace

namespace isosurface
{

void AllocationCounter::Reset()
{
  Current = 0;
  Peak = 0;
}

std::size_t AllocationCounter::GetPeak()
{
  return static_cast<std::size_t>(Peak.load());
}

} // namespace isosurface

namespace
{

// The size of an allocation is kept in front of it, in as many bytes as keep it aligned.
constexpr std::size_t Prefix = alignof(std::max_align_t);
static_assert(Prefix >= sizeof(std::size_t), "the size fits in front");

void* Allocate(std::size_t size)
{
  void* memory = std::malloc(size + Prefix);
  if (!memory)
  {
    throw std::bad_alloc();
  }
  *static_cast<std::size_t*>(memory) = size;
  const auto bytes = static_cast<std::ptrdiff_t>(size);
  const std::ptrdiff_t now = Current.fetch_add(bytes) + bytes;
  std::ptrdiff_t peak = Peak.load();
  while (now > peak && !Peak.compare_exchange_weak(peak, now))
  {
  }
  return static_cast<char*>(memory) + Prefix;
}

void Free(void* memory) noexcept
{
  if (memory)
  {
    void* begin = static_cast<char*>(memory) - Prefix;
    Current.fetch_sub(static_cast<std::ptrdiff_t>(*static_cast<std::size_t*>(begin)));
    std::free(begin);
  }
}

} // namespace

void* operator new(std::size_t size)
{
  return Allocate(size);
}
void* operator new[](std::size_t size)
{
  return Allocate(size);
}
void operator delete(void* memory) noexcept
{
  Free(memory);
}
void operator delete[](void* memory) noexcept
{
  Free(memory);
}
void operator delete(void* memory, std::size_t) noexcept
{
  Free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept
{
  Free(memory);
}
