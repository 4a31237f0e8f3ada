// SPDX-License-Identifier: BSD-3-Clause
#include "FuzzTarget.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__)
#  define ISOSURFACE_TELLS_ALLOCATIONS
#elif defined(__has_feature)
#  if __has_feature(address_sanitizer)
#    define ISOSURFACE_TELLS_ALLOCATIONS
#  endif
#endif

#ifdef ISOSURFACE_TELLS_ALLOCATIONS
// Of <sanitizer/allocator_interface.h>, which GCC does not install.
extern "C" int __sanitizer_install_malloc_and_free_hooks(
  void (*allocated)(const volatile void*, std::size_t), void (*released)(const volatile void*));
extern "C" std::size_t __sanitizer_get_allocated_size(const volatile void*);
#endif

namespace isosurface
{
namespace
{

std::atomic<std::ptrdiff_t> Allocated(0);
std::atomic<std::ptrdiff_t> Peak(0);
std::ptrdiff_t Limit = 0;

#ifdef ISOSURFACE_TELLS_ALLOCATIONS
void CountAllocation(const volatile void*, std::size_t size)
{
  Allocated += static_cast<std::ptrdiff_t>(size);
  if (Allocated > Peak)
  {
    Peak = Allocated.load();
  }
}

void CountRelease(const volatile void* bytes)
{
  Allocated -= static_cast<std::ptrdiff_t>(__sanitizer_get_allocated_size(bytes));
}
#endif

} // namespace

void Require(bool holds, const char* claim)
{
  if (!holds)
  {
    std::fprintf(stderr, "This does not hold: %s\n", claim);
    std::abort();
  }
}

MemoryLimit::MemoryLimit(std::size_t limit)
{
#ifdef ISOSURFACE_TELLS_ALLOCATIONS
  static const int installed =
    __sanitizer_install_malloc_and_free_hooks(CountAllocation, CountRelease);
  Require(installed != 0, "the sanitizer takes our hooks");
#endif
  Allocated = 0;
  Peak = 0;
  Limit = static_cast<std::ptrdiff_t>(limit);
}

MemoryLimit::~MemoryLimit()
{
  if (Peak > Limit)
  {
    std::fprintf(
      stderr, "%td bytes were allocated at a time, %td are allowed\n", Peak.load(), Limit);
    std::abort();
  }
}

} // namespace isosurface
