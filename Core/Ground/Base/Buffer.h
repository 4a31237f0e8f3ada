// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Buffer_h
#define isosurface_Buffer_h

#include "Ground/Base/KeptMemory.h"

#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>

namespace isosurface
{

/**
 * An array of fixed size that is not initialised, so that each value is written only once. The
 * memory comes from TakeMemory(): Release() can hand it to an owner that calls ReleaseMemory(), such as
 * a VTK data array. The constructor throws std::bad_alloc if memory is short.
 */
template <typename T>
class Buffer
{
  static_assert(std::is_trivially_copyable_v<T>, "a buffer holds plain values");

public:
  Buffer() = default;
  explicit Buffer(std::size_t size)
    : Data(size == 0 ? nullptr : static_cast<T*>(TakeMemory(Bytes(size))))
    , Size(size)
  {
    if (size != 0 && !this->Data)
    {
      throw std::bad_alloc();
    }
  }
  Buffer(Buffer&& other) noexcept
    : Data(std::exchange(other.Data, nullptr))
    , Size(std::exchange(other.Size, 0))
  {
  }
  Buffer& operator=(Buffer&& other) noexcept
  {
    std::swap(this->Data, other.Data);
    std::swap(this->Size, other.Size);
    return *this;
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { ReleaseMemory(this->Data); }

  T* GetData() { return this->Data; }
  const T* GetData() const { return this->Data; }
  std::size_t GetSize() const { return this->Size; }
  bool IsEmpty() const { return this->Size == 0; }

  T& operator[](std::size_t index) { return this->Data[index]; }
  const T& operator[](std::size_t index) const { return this->Data[index]; }
  T* begin() { return this->Data; }
  T* end() { return this->Data + this->Size; }
  const T* begin() const { return this->Data; }
  const T* end() const { return this->Data + this->Size; }

  /// Hands over the memory, to be released by ReleaseMemory(). The buffer is empty afterwards.
  T* Release()
  {
    this->Size = 0;
    return std::exchange(this->Data, nullptr);
  }

private:
  static std::size_t Bytes(std::size_t size)
  {
    if (size > static_cast<std::size_t>(-1) / sizeof(T))
    {
      throw std::bad_alloc();
    }
    return size * sizeof(T);
  }

  T* Data = nullptr;
  std::size_t Size = 0;
};

} // namespace isosurface

#endif
