// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ValueKey_h
#define isosurface_ValueKey_h

#include "Ground/Volume/ValueType.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>

namespace isosurface
{

/**
 * Represents values of every type as unsigned 64-bit keys that have the same order, so that one
 * index serves all types without loss, int64 and uint64 included.
 *
 * - integers: the value minus the minimum of its type, plus 1;
 * - floats: the IEEE bits made monotonic, in the width of the type; -0.0 and +0.0 share a key;
 * - NaN: key 0, below all others, since NaN is outside (value >= isovalue is false).
 *
 * The maximum uint64 has the key of its predecessor, so that 0 remains free for NaN.
 */
using ValueKey = std::uint64_t;

/// The key of NaN; no other value has it.
constexpr ValueKey NotANumberKey = 0;

template <typename T>
ValueKey MakeValueKey(T value)
{
  if constexpr (std::is_floating_point_v<T>)
  {
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    static_assert(sizeof(T) == sizeof(Bits));
    if (std::isnan(value))
    {
      return NotANumberKey;
    }
    value += T(0); // -0.0 becomes +0.0
    Bits bits;
    std::memcpy(&bits, &value, sizeof(bits));
    constexpr Bits sign = Bits(1) << (8 * sizeof(Bits) - 1);
    return static_cast<ValueKey>((bits & sign) ? Bits(~bits) : Bits(bits | sign));
  }
  else
  {
    using Unsigned = std::make_unsigned_t<T>;
    static_assert(sizeof(T) <= sizeof(ValueKey));
    const auto shifted = static_cast<Unsigned>(
      static_cast<Unsigned>(value) - static_cast<Unsigned>(std::numeric_limits<T>::min()));
    const auto key = static_cast<ValueKey>(shifted);
    return key == std::numeric_limits<ValueKey>::max() ? key : key + 1;
  }
}

/// The value of a key: the inverse of MakeValueKey(), except where two values share a key.
template <typename T>
T MakeValueOfKey(ValueKey key)
{
  if constexpr (std::is_floating_point_v<T>)
  {
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    if (key == NotANumberKey)
    {
      return std::numeric_limits<T>::quiet_NaN();
    }
    constexpr Bits sign = Bits(1) << (8 * sizeof(Bits) - 1);
    const auto bits = static_cast<Bits>(key);
    const Bits original = (bits & sign) ? Bits(bits ^ sign) : Bits(~bits);
    T value;
    std::memcpy(&value, &original, sizeof(value));
    return value;
  }
  else
  {
    using Unsigned = std::make_unsigned_t<T>;
    return static_cast<T>(static_cast<Unsigned>(static_cast<Unsigned>(key == 0 ? 0 : key - 1) +
      static_cast<Unsigned>(std::numeric_limits<T>::min())));
  }
}

/// The same for a type that is known at run time; as a double, which may round integers of 64 bits.
inline double GetValueOfKey(ValueType type, ValueKey key)
{
  return DispatchValueType(
    type, [key](auto zero) { return static_cast<double>(MakeValueOfKey<decltype(zero)>(key)); });
}

/**
 * The threshold of an isovalue: the minimum value t of type T with t >= isovalue. So a value v of
 * the type is inside (v >= isovalue) if and only if v >= t. Nothing if no value is inside: the
 * isovalue is above all of them, or NaN.
 */
template <typename T>
std::optional<T> FindThreshold(double isovalue)
{
  if (std::isnan(isovalue))
  {
    return std::nullopt;
  }
  if constexpr (std::is_same_v<T, double>)
  {
    return isovalue;
  }
  else if constexpr (std::is_same_v<T, float>)
  {
    auto threshold = static_cast<float>(isovalue); // to nearest; beyond the range: infinity
    if (static_cast<double>(threshold) < isovalue)
    {
      threshold = std::nextafter(threshold, std::numeric_limits<float>::infinity());
    }
    return threshold;
  }
  else
  {
    // Both are powers of two or zero, hence exact as doubles; `end` is one above the maximum.
    const double end = std::ldexp(1.0, std::numeric_limits<T>::digits);
    const auto minimum = static_cast<double>(std::numeric_limits<T>::min());
    const double ceiling = std::ceil(isovalue);
    if (ceiling >= end)
    {
      return std::nullopt;
    }
    return ceiling <= minimum ? std::numeric_limits<T>::min() : static_cast<T>(ceiling);
  }
}

/// A closed range [Minimum, Maximum] of keys; empty if Minimum > Maximum.
struct KeyRange
{
  ValueKey Minimum = std::numeric_limits<ValueKey>::max();
  ValueKey Maximum = 0;

  bool IsEmpty() const { return this->Minimum > this->Maximum; }
  bool Contains(const KeyRange& other) const
  {
    return other.IsEmpty() || (this->Minimum <= other.Minimum && other.Maximum <= this->Maximum);
  }
  void Add(const KeyRange& other)
  {
    this->Minimum = std::min(this->Minimum, other.Minimum);
    this->Maximum = std::max(this->Maximum, other.Maximum);
  }

  /// Its ends as values; NaN if it is empty.
  std::array<double, 2> GetValues(ValueType type) const
  {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    return this->IsEmpty()
      ? std::array{ none, none }
      : std::array{ GetValueOfKey(type, this->Minimum), GetValueOfKey(type, this->Maximum) };
  }

  /// Whether the range has values on both sides of the threshold: Minimum < threshold <= Maximum.
  /// If not, no isosurface crosses a block of this range.
  bool Straddles(ValueKey threshold) const
  {
    return this->Minimum < threshold && threshold <= this->Maximum;
  }
};

} // namespace isosurface

#endif
