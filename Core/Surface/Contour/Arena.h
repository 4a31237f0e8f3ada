// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Arena_h
#define isosurface_Arena_h

#include "Ground/Base/Buffer.h"
#include "Ground/Base/HugePages.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Memory that is allocated from front to back and freed as a whole. Allocations are aligned to 64
 * bytes. For one thread at a time.
 */
class Arena
{
public:
  /// Returns room for up to `count` values. Valid until the next call unless kept by Keep().
  template <typename T>
  T* Reserve(std::size_t count)
  {
    const std::size_t bytes = count * sizeof(T);
    if (this->Chunks.empty() || this->Chunks.back().GetSize() - this->Used < bytes)
    {
      const std::size_t size = this->Chunks.empty()
        ? FirstChunkSize
        : std::min(2 * this->Chunks.back().GetSize(), MaximumChunkSize);
      this->Chunks.emplace_back(std::max(size, bytes + Alignment));
      AdviseHugePages(this->Chunks.back().GetData(), this->Chunks.back().GetSize());
      const auto address = reinterpret_cast<std::uintptr_t>(this->Chunks.back().GetData());
      this->Used = (Alignment - address % Alignment) % Alignment;
    }
    return reinterpret_cast<T*>(this->Chunks.back().GetData() + this->Used);
  }

  /// Keeps the first `count` values of the last reservation.
  template <typename T>
  void Keep(std::size_t count)
  {
    const std::size_t bytes = (count * sizeof(T) + Alignment - 1) / Alignment * Alignment;
    this->Used = std::min(this->Used + bytes, this->Chunks.back().GetSize());
  }

  template <typename T>
  T* Allocate(std::size_t count)
  {
    T* values = this->Reserve<T>(count);
    this->Keep<T>(count);
    return values;
  }

private:
  // The first chunk is small, so that a small surface does not take much memory.
  static constexpr std::size_t FirstChunkSize = std::size_t(1) << 18;
  static constexpr std::size_t MaximumChunkSize = std::size_t(8) << 20;
  static constexpr std::size_t Alignment = 64;

  std::vector<Buffer<std::uint8_t>> Chunks;
  std::size_t Used = 0; ///< bytes of the last chunk
};

} // namespace isosurface

#endif
