// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/HugePages.h"

#include <cstdint>

#if defined(__linux__)
#  include <sys/mman.h>
#endif

namespace isosurface
{

void AdviseHugePages(void* memory, std::size_t size)
{
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  constexpr std::uintptr_t page = std::uintptr_t(2) << 20;
  const auto address = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t begin = (address + page - 1) / page * page;
  const std::uintptr_t end = (address + size) / page * page;
  if (memory && begin < end)
  {
    // The system may refuse; the memory works without huge pages as well.
    (void)madvise(static_cast<char*>(memory) + (begin - address), end - begin, MADV_HUGEPAGE);
  }
#else
  (void)memory;
  (void)size;
#endif
}

} // namespace isosurface
