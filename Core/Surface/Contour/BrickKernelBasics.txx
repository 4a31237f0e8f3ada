// SPDX-License-Identifier: BSD-3-Clause
// Bits, sample types and their exact differences. A part of BrickKernel.txx.
#ifndef isosurface_BrickKernelBasics_txx
#define isosurface_BrickKernelBasics_txx

#include "Surface/Contour/BrickKernel.h"

namespace isosurface
{
namespace ISOSURFACE_KERNEL
{
namespace
{

using Word = std::uint64_t;

inline int CountBits(Word bits)
{
  return __builtin_popcountll(bits);
}
inline int FindFirstBit(Word bits) // of a word that is not 0
{
  return __builtin_ctzll(bits);
}
inline Word MaskBelow(int bit)
{
  return (Word(1) << bit) - 1;
}

template <typename T>
struct IsFloating
{
  static constexpr bool Value = T(0.5) != T(0);
};

template <typename T>
constexpr bool IsWide = !IsFloating<T>::Value && sizeof(T) == 8;

// a - b without overflow, with a single rounding.
template <typename T>
inline double Subtract(T a, T b)
{
  if constexpr (IsFloating<T>::Value)
  {
    return static_cast<double>(static_cast<T>(a - b));
  }
  else if constexpr (IsWide<T>)
  {
    return a >= b ? static_cast<double>(Word(a) - Word(b))
                  : -static_cast<double>(Word(b) - Word(a));
  }
  else
  {
    return static_cast<double>(a) - static_cast<double>(b);
  }
}

// As DispatchValueType, which kernels may not call: see BrickKernels.
template <typename Functor>
inline void Dispatch(ValueType type, const Functor& functor)
{
  // clang-format off
  switch (type)
  {
    case ValueType::Int8: functor(std::int8_t{}); break;
    case ValueType::UInt8: functor(std::uint8_t{}); break;
    case ValueType::Int16: functor(std::int16_t{}); break;
    case ValueType::UInt16: functor(std::uint16_t{}); break;
    case ValueType::Int32: functor(std::int32_t{}); break;
    case ValueType::UInt32: functor(std::uint32_t{}); break;
    case ValueType::Int64: functor(std::int64_t{}); break;
    case ValueType::UInt64: functor(std::uint64_t{}); break;
    case ValueType::Float32: functor(float{}); break;
    case ValueType::Float64: functor(double{}); break;
  }
  // clang-format on
}

inline int PlaceOf(int index, int size)
{
  return index == 0 ? 0 : index == size - 1 ? 2 : 1;
}

} // namespace
} // namespace ISOSURFACE_KERNEL
} // namespace isosurface

#endif
