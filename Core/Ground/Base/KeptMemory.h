// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_KeptMemory_h
#define isosurface_KeptMemory_h

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// Smaller memory is not kept: the heap keeps it.
constexpr std::size_t SmallestKept = std::size_t(1) << 20;
/// More is not kept by a process, nor more than an eighth of the memory that is available.
constexpr std::uint64_t LargestKept = std::uint64_t(1) << 30;

/**
 * Memory of large buffers, kept for the next ones when it is released. A surface is about as large as
 * that of the isovalue before, and the system takes a quarter to a third of the time of both to clear
 * the pages that it gives. Any thread may call these functions.
 *
 * TakeMemory() returns memory for `size` bytes as malloc() does, with undefined content, or nullptr. It
 * may be a quarter larger. If there is none, all that is kept is freed first.
 */
void* TakeMemory(std::size_t size);

/// Keeps memory of TakeMemory() or of malloc() in place of the memory released longest ago, or
/// frees it. Memory that was taken may also be freed by free().
void ReleaseMemory(void* memory) noexcept;

/// Frees all kept memory.
void FreeKeptMemory() noexcept;

/// Bytes that are kept, and not in use.
std::uint64_t GetKeptBytes();

} // namespace isosurface

#endif
