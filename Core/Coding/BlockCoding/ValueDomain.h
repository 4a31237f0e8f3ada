// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ValueDomain_h
#define isosurface_ValueDomain_h

#include "Ground/Volume/ValueType.h"

#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace isosurface
{

/**
 * Maps values to integers of two kinds: codes, which are coded, and heights above the isovalue
 * (-4095 to 4095), which predictions are computed with.
 *
 * - Offsets: integers of 8 to 32 bits, and quantized values. The code is the value minus the
 *   threshold, so inside is code >= 0, and signs bound the codes.
 * - Bits: all other types. The code is the value's bits in the order of values (floats: the bits made
 *   monotonic), modulo 2^32 or 2^64. Signs do not bound it: NaN, above infinity, is outside.
 *
 * Heights are integers, so that encoders and decoders on every machine make the same predictions.
 */
class ValueDomain
{
public:
  enum class Kind : std::uint8_t
  {
    Offsets,
    Bits
  };

  static constexpr std::int32_t MaximumHeight = 4095;

  /// For lossless values of a type. scale: heights are in units of 2^-scale, see ToHeight.
  ValueDomain(ValueType type, double isovalue, int scale);

  /// For quantized values: codes from `minimum` to `maximum`.
  static ValueDomain MakeQuantized(std::int64_t minimum, std::int64_t maximum, int scale);

  Kind GetKind() const { return this->Codes; }

  /// The code of a value of the type, and back. T must be the type of the domain.
  template <typename T>
  std::int64_t ToCode(T value) const
  {
    if constexpr (std::is_floating_point_v<T>)
    {
      SignedBits<T> bits;
      std::memcpy(&bits, &value, sizeof(bits));
      return MakeMonotonic(bits);
    }
    else
    {
      return static_cast<std::int64_t>(value) - this->Threshold;
    }
  }
  template <typename T>
  T ToValue(std::int64_t code) const
  {
    if constexpr (std::is_floating_point_v<T>)
    {
      const auto bits = MakeMonotonic(static_cast<SignedBits<T>>(code));
      T value;
      std::memcpy(&value, &bits, sizeof(value));
      return value;
    }
    else
    {
      return static_cast<T>(code + this->Threshold);
    }
  }

  /// The bits of floats as integers of the same order. It is its own inverse.
  template <typename Signed>
  static Signed MakeMonotonic(Signed bits)
  {
    return bits < 0 ? static_cast<Signed>(bits ^ std::numeric_limits<Signed>::max()) : bits;
  }

  /// Bounds of the codes of vertices inside, or outside; only for offsets.
  std::int64_t GetMinimum(bool inside) const { return inside ? 0 : this->Minimum; }
  std::int64_t GetMaximum(bool inside) const { return inside ? this->Maximum : -1; }

  /**
   * Offsets: the middle of [code, code + 1) in units of 2^-scale, rounded down if scale < 1. Bits:
   * value - isovalue in units of 2^-scale, rounded down; 0 for NaN.
   */
  std::int32_t ToHeight(std::int64_t code) const
  {
    if (this->Codes == Kind::Offsets)
    {
      const std::int64_t middle = 2 * code + 1; // in halves
      const std::int64_t height = this->Scale >= 1
        ? middle * (std::int64_t{ 1 } << (this->Scale - 1))
        : middle >> (1 - this->Scale);
      return static_cast<std::int32_t>(height < -MaximumHeight ? -MaximumHeight
          : height > MaximumHeight                             ? MaximumHeight
                                                               : height);
    }
    return this->BitsToHeight(code);
  }

  /// The code of a height. `quarter` becomes the quarter of [code, code + 1) that the height lies
  /// in, 0 to 3; 0 for bits, and where a height stands for several codes.
  std::int64_t FromHeight(std::int32_t height, int& quarter) const
  {
    quarter = 0;
    if (this->Codes == Kind::Bits)
    {
      return this->BitsFromHeight(height);
    }
    if (this->Scale <= 0)
    {
      return static_cast<std::int64_t>(height) * (std::int64_t{ 1 } << -this->Scale);
    }
    quarter = (this->Scale >= 2 ? height >> (this->Scale - 2) : 2 * height) & 3;
    return height >> this->Scale;
  }

  /// Bits only: a code modulo 2^32 or 2^64.
  std::int64_t Wrap(std::uint64_t code) const
  {
    return this->IsNarrow ? static_cast<std::int32_t>(static_cast<std::uint32_t>(code))
                          : static_cast<std::int64_t>(code);
  }

private:
  template <typename T>
  using SignedBits = std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t>;

  ValueDomain() = default;
  std::int32_t BitsToHeight(std::int64_t code) const;
  std::int64_t BitsFromHeight(std::int32_t height) const;

  Kind Codes = Kind::Offsets;
  ValueType Type = ValueType::UInt8;
  bool IsNarrow = false; ///< codes have 32 bits
  int Scale = 0;
  int FineBits = 0;          ///< fixed-point numbers are in units of 2^-(Scale + FineBits)
  std::int64_t Isovalue = 0; ///< as a fixed-point number
  std::int64_t Threshold = 0;
  std::int64_t Minimum = 0;
  std::int64_t Maximum = 0;
};

/// The scale at which a typical distance from the isovalue becomes a height of 512 to 1023.
int ChooseScale(double typicalDistance);

} // namespace isosurface

#endif
