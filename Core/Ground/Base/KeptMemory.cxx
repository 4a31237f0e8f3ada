// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/KeptMemory.h"

#include "Ground/Base/AvailableMemory.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <new>
#include <vector>

#if defined(__GLIBC__)
#  include <malloc.h>
#endif
#include <sanitizer/asan_interface.h> // with AddressSanitizer, whoever uses what is released is found as ever

namespace isosurface
{
namespace
{

struct Block
{
  void* Memory = nullptr;
  std::size_t Size = 0;
};

/// What malloc() gave; 0 if only it knows.
std::size_t MeasureBlock(void* memory)
{
#if defined(__GLIBC__)
  return ::malloc_usable_size(memory);
#else
  (void)memory;
  return 0;
#endif
}

class KeptBlocks
{
public:
  void* Take(std::size_t size)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    auto best = this->Blocks.end();
    for (auto block = this->Blocks.begin(); block != this->Blocks.end(); ++block)
    {
      if (block->Size >= size && block->Size - size <= size / 4 &&
        (best == this->Blocks.end() || block->Size <= best->Size)) // the last one may be in a cache
      {
        best = block;
      }
    }
    if (best == this->Blocks.end())
    {
      return nullptr;
    }
    const Block taken = *best;
    this->Blocks.erase(best);
    this->Bytes -= taken.Size;
    ASAN_UNPOISON_MEMORY_REGION(taken.Memory, taken.Size);
    return taken.Memory;
  }

  /// False if it may not be kept.
  bool Put(const Block& block)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    if (this->Puts++ % 16 == 0) // to ask takes as long as to clear some pages
    {
      this->Most = std::min(LargestKept, GetAvailableMemory() / 8);
    }
    if (block.Size > this->Most)
    {
      return false;
    }
    this->FreeOldest(this->Most - block.Size);
    try
    {
      this->Blocks.push_back(block);
    }
    catch (const std::bad_alloc&)
    {
      return false;
    }
    this->Bytes += block.Size;
    ASAN_POISON_MEMORY_REGION(block.Memory, block.Size);
    return true;
  }

  /// False if there was nothing.
  bool FreeAll()
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    return this->FreeOldest(0);
  }

  std::uint64_t GetBytes()
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    return this->Bytes;
  }

private:
  /// Until no more than `rest` bytes are left.
  bool FreeOldest(std::uint64_t rest)
  {
    auto block = this->Blocks.begin();
    for (; this->Bytes > rest; ++block)
    {
      this->Bytes -= block->Size;
      ASAN_UNPOISON_MEMORY_REGION(block->Memory, block->Size);
      std::free(block->Memory);
    }
    const bool any = block != this->Blocks.begin();
    this->Blocks.erase(this->Blocks.begin(), block);
    return any;
  }

  std::mutex Mutex;
  std::vector<Block> Blocks; ///< in the order in which they were released
  std::uint64_t Bytes = 0;
  std::uint64_t Most = 0; ///< bytes that may be kept
  std::uint64_t Puts = 0;
};

/// Never destroyed: arrays may be released after all static objects.
KeptBlocks& GetKeptBlocks()
{
  static auto* const kept = new KeptBlocks;
  return *kept;
}

} // namespace

void* TakeMemory(std::size_t size)
{
  void* memory = size >= SmallestKept ? GetKeptBlocks().Take(size) : nullptr;
  if (!memory)
  {
    memory = std::malloc(size);
  }
  if (!memory && size >= SmallestKept && GetKeptBlocks().FreeAll())
  {
    memory = std::malloc(size);
  }
  return memory;
}

void ReleaseMemory(void* memory) noexcept
{
  const Block block = { memory, memory ? MeasureBlock(memory) : 0 };
  if (block.Size < SmallestKept || !GetKeptBlocks().Put(block))
  {
    std::free(memory);
  }
}

void FreeKeptMemory() noexcept
{
  GetKeptBlocks().FreeAll();
}

std::uint64_t GetKeptBytes()
{
  return GetKeptBlocks().GetBytes();
}

} // namespace isosurface
