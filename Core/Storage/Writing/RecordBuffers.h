// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RecordBuffers_h
#define isosurface_RecordBuffers_h

#include "Ground/Base/Buffer.h"

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

namespace isosurface
{

/// The memory of records, reused in each round, since the first access to new memory costs as much
/// as filling it. Holds the maximum number of buffers that were in use at once. Safe for all
/// threads.
class RecordBuffers
{
public:
  /// `size`: of each buffer, enough for any record.
  explicit RecordBuffers(std::size_t size)
    : Size(size)
  {
  }

  Buffer<std::uint8_t> Take()
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    if (this->Idle.empty())
    {
      this->Idle.reserve(++this->Count); // so that Return() never needs memory
      return Buffer<std::uint8_t>(this->Size);
    }
    Buffer<std::uint8_t> buffer = std::move(this->Idle.back());
    this->Idle.pop_back();
    return buffer;
  }

  void Return(Buffer<std::uint8_t> buffer)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->Idle.push_back(std::move(buffer));
  }

private:
  std::size_t Size;
  std::size_t Count = 0;
  std::mutex Mutex;
  std::vector<Buffer<std::uint8_t>> Idle;
};

} // namespace isosurface

#endif
