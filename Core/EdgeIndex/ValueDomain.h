// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ValueDomain_h
#define isosurface_ValueDomain_h

#include "Volume/ValueType.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/**
 * Values as the integers that are coded (codes), and as the small ones that are predicted with
 * (heights above the isovalue, from -4095 to 4095).
 *
 * - Offsets: integers of 8 to 32 bits, and quantized values; the code is the value less the least
 *   one that is inside, so inside is code >= 0, and the signs bound the codes.
 * - Bits: everything else; the code is the value's bits in an order that follows the values
 *   (floats: the bits made monotonic), modulo 2^32 or 2^64. Inside and outside do not bound it: NaN
 *   stands above infinity and is outside.
 */
class ValueDomain
{
public:
  enum class Kind : std::uint8_t
  {
    Offsets,
    Bits
  };

  static constexpr std::int32_t MostHeight = 4095;

  /// For lossless values of the type. `scale` is a binary exponent: see ToHeight.
  ValueDomain(ValueType type, double isovalue, int scale);

  /// For values that were quantized: codes from `least` to `greatest`.
  static ValueDomain MakeQuantized(std::int64_t least, std::int64_t greatest, int scale);

  Kind GetKind() const { return this->Codes; }

  /// The code of a value of the type, and back.
  std::int64_t ToCode(const void* value) const;
  void ToValue(std::int64_t code, void* value) const;

  /// Bounds of the codes of vertices inside, or outside; only for offsets.
  std::int64_t GetLeast(bool inside) const { return inside ? 0 : this->Least; }
  std::int64_t GetGreatest(bool inside) const { return inside ? this->Greatest : -1; }

  /**
   * Offsets: the middle of [code, code + 1) in units of 2^-scale, rounded down if scale < 1. Bits:
   * value - isovalue in units of 2^-scale, rounded down; 0 for NaN. In integers, so that it is the
   * same on every machine.
   */
  std::int32_t ToHeight(std::int64_t code) const;

  /// The code that has about a height. `quarter` is where in its interval the height lies, 0 to 3.
  std::int64_t FromHeight(std::int32_t height, int& quarter) const;

  /// Codes of a type with 32 bits, or 64, wrap around.
  int GetWidth() const { return this->Width; }

private:
  ValueDomain() = default;

  Kind Codes = Kind::Offsets;
  ValueType Type = ValueType::UInt8;
  int Width = 64;
  int Scale = 0;
  int FineBits = 0;          ///< of fixed numbers, below heights
  std::int64_t Isovalue = 0; ///< as a fixed number
  std::int64_t Threshold = 0;
  std::int64_t Least = 0;
  std::int64_t Greatest = 0;
};

/// The scale at which a typical distance from the isovalue becomes a height of about 1000.
int ChooseScale(double typicalDistance);

} // namespace isosurface

#endif
