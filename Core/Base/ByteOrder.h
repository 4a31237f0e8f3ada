// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ByteOrder_h
#define isosurface_ByteOrder_h

#include <cstddef>
#include <cstring>
#include <type_traits>

// Every file of this project is little-endian. Loads and stores go through these two functions, so
// that a big-endian port has one place to change.
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#  error "ScalableIsosurface reads and writes little-endian files and has no byte swapping yet."
#endif

namespace isosurface
{

/// Reads a little-endian value from bytes of any alignment.
template <typename T>
T LoadLittleEndian(const void* bytes)
{
  static_assert(std::is_trivially_copyable_v<T>, "only plain values have a byte order");
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

/// Writes a value as little-endian bytes at any alignment.
template <typename T>
void StoreLittleEndian(void* bytes, T value)
{
  static_assert(std::is_trivially_copyable_v<T>, "only plain values have a byte order");
  std::memcpy(bytes, &value, sizeof(T));
}

} // namespace isosurface

#endif
