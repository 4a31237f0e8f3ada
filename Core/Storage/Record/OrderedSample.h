// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_OrderedSample_h
#define isosurface_OrderedSample_h

#include <cstdint>
#include <type_traits>

namespace isosurface
{

/// The unsigned integer as large as a sample.
template <typename T>
using OrderedOf = std::conditional_t<sizeof(T) == 1, std::uint8_t,
  std::conditional_t<sizeof(T) == 2, std::uint16_t,
    std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;

/// Converts the bits of samples of type T to unsigned integers u of the same order, and back.
/// Unsigned integers stay; of signed ones the highest bit is inverted; of floats the highest bit is
/// inverted if it is 0, else all bits. Exact for every pattern of bits.
template <typename T>
struct OrderedSample
{
  using Unsigned = OrderedOf<T>;
  static constexpr int HighestBit = 8 * static_cast<int>(sizeof(T)) - 1;
  static constexpr Unsigned Sign = static_cast<Unsigned>(Unsigned{ 1 } << HighestBit);

  static Unsigned FromBits(Unsigned bits)
  {
    if constexpr (std::is_floating_point_v<T>)
    {
      const auto negative = static_cast<Unsigned>(0 - (bits >> HighestBit));
      return bits ^ (negative | Sign);
    }
    else if constexpr (std::is_signed_v<T>)
    {
      return static_cast<Unsigned>(bits ^ Sign);
    }
    else
    {
      return bits;
    }
  }

  static Unsigned ToBits(Unsigned ordered)
  {
    if constexpr (std::is_floating_point_v<T>)
    {
      const auto positive = static_cast<Unsigned>(0 - (ordered >> HighestBit));
      return ordered ^ static_cast<Unsigned>(static_cast<Unsigned>(~positive) | Sign);
    }
    else
    {
      return FromBits(ordered);
    }
  }
};

} // namespace isosurface

#endif
