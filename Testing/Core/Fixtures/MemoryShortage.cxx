// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/MemoryShortage.h"

#include "Ground/Base/KeptMemory.h"

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>

#include <dlfcn.h>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#  define ISOSURFACE_WATCHES_MALLOC
#endif

namespace
{

std::atomic<bool> IsWatched = false;
std::atomic<bool> IsOfThread = false;
thread_local bool IsWatchedThread = false;
std::atomic<long> Failing = -1;
std::atomic<long> Asked = 0;

bool IsToFail(std::size_t size)
{
  return IsWatched && size >= isosurface::LargeBytes && (!IsOfThread || IsWatchedThread) &&
    Asked++ == Failing;
}

#ifdef ISOSURFACE_WATCHES_MALLOC
extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_realloc(void*, std::size_t);

/// Whether a caller of malloc is of this project.
bool IsOurs(void* caller)
{
  Dl_info info;
  if (dladdr(caller, &info) == 0 || !info.dli_fname)
  {
    return false;
  }
  const char* slash = std::strrchr(info.dli_fname, '/');
  const char* name = slash ? slash + 1 : info.dli_fname;
  return std::strstr(name, "Isosurface") || std::strncmp(name, "Test", 4) == 0;
}
#endif

void* AllocateUnwatched(std::size_t size)
{
#ifdef ISOSURFACE_WATCHES_MALLOC
  return __libc_malloc(size);
#else
  return std::malloc(size);
#endif
}

void* AllocateOrThrow(std::size_t size)
{
  void* memory = IsToFail(size) ? nullptr : AllocateUnwatched(size == 0 ? 1 : size);
  if (!memory)
  {
    throw std::bad_alloc();
  }
  return memory;
}

} // namespace

void* operator new(std::size_t size)
{
  return AllocateOrThrow(size);
}
void* operator new[](std::size_t size)
{
  return AllocateOrThrow(size);
}
void operator delete(void* memory) noexcept
{
  std::free(memory);
}
void operator delete[](void* memory) noexcept
{
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept
{
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept
{
  std::free(memory);
}

#ifdef ISOSURFACE_WATCHES_MALLOC
extern "C" void* malloc(std::size_t size)
{
  if (IsWatched && size >= isosurface::LargeBytes && IsOurs(__builtin_return_address(0)) &&
    IsToFail(size))
  {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_malloc(size);
}

extern "C" void* realloc(void* memory, std::size_t size)
{
  if (IsWatched && size >= isosurface::LargeBytes && IsOurs(__builtin_return_address(0)) &&
    IsToFail(size))
  {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_realloc(memory, size);
}
#endif

namespace isosurface
{

MemoryShortage::MemoryShortage(long allocation, Of whom)
{
  FreeKeptMemory(); // which would not be asked for
  Asked = 0;
  Failing = allocation;
  IsOfThread = whom == Of::Thread;
  IsWatchedThread = true;
  IsWatched = true;
}

MemoryShortage::~MemoryShortage()
{
  IsWatched = false;
  IsWatchedThread = false;
}

long MemoryShortage::Count()
{
  return Asked;
}

} // namespace isosurface
