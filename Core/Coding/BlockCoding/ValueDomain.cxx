// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/ValueDomain.h"

#include "Ground/Volume/ValueKey.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

std::int32_t ClampHeight(std::int64_t height)
{
  return static_cast<std::int32_t>(
    std::clamp<std::int64_t>(height, -ValueDomain::MaximumHeight, ValueDomain::MaximumHeight));
}

// The number (-1)^IsNegative * Mantissa * 2^Exponent.
struct BinaryNumber
{
  bool IsNegative = false;
  bool IsNan = false;
  std::uint64_t Mantissa = 0;
  int Exponent = 0;
};

// The number that the bits of IEEE 754 stand for. Infinity is the number after the maximum.
BinaryNumber Decompose(std::uint64_t bits, int mantissaBits, int exponentBits)
{
  BinaryNumber number;
  const std::uint64_t fraction = bits & ((std::uint64_t{ 1 } << mantissaBits) - 1);
  const auto maximum = (1 << exponentBits) - 1;
  const auto exponent =
    static_cast<int>(bits >> mantissaBits & static_cast<std::uint64_t>(maximum));
  number.IsNegative = (bits >> (mantissaBits + exponentBits) & 1) != 0;
  number.IsNan = exponent == maximum && fraction != 0;
  number.Mantissa = exponent == 0 ? fraction : fraction | std::uint64_t{ 1 } << mantissaBits;
  number.Exponent = std::max(exponent, 1) - maximum / 2 - mantissaBits;
  return number;
}

// The bits of the next finite number towards zero.
std::uint64_t Compose(BinaryNumber number, int mantissaBits, int exponentBits)
{
  const int maximum = (1 << exponentBits) - 1;
  const std::uint64_t sign =
    number.IsNegative ? std::uint64_t{ 1 } << (mantissaBits + exponentBits) : 0;
  if (number.Mantissa == 0)
  {
    return sign;
  }
  const int length = 64 - __builtin_clzll(number.Mantissa);
  // As it is stored; 1 and less stand for subnormal numbers.
  const int exponent = number.Exponent + length - 1 + maximum / 2;
  if (exponent >= maximum)
  {
    return sign | ((static_cast<std::uint64_t>(maximum) << mantissaBits) - 1);
  }
  const int shift = length - 1 - mantissaBits + std::max(0, 1 - exponent);
  const std::uint64_t mantissa = shift >= 64 ? 0
    : shift >= 0                             ? number.Mantissa >> shift
                                             : number.Mantissa << -shift;
  const std::uint64_t fraction = mantissa & ((std::uint64_t{ 1 } << mantissaBits) - 1);
  return sign | static_cast<std::uint64_t>(std::max(exponent, 0)) << mantissaBits | fraction;
}

BinaryNumber DecomposeCode(ValueType type, std::int64_t code)
{
  switch (type)
  {
    case ValueType::Float32:
    {
      const auto narrow = ValueDomain::MakeMonotonic(static_cast<std::int32_t>(code));
      return Decompose(static_cast<std::uint32_t>(narrow), 23, 8);
    }
    case ValueType::Float64:
      return Decompose(static_cast<std::uint64_t>(ValueDomain::MakeMonotonic(code)), 52, 11);
    default:
    {
      BinaryNumber number;
      number.IsNegative = type == ValueType::Int64 && code < 0;
      number.Mantissa =
        number.IsNegative ? 0 - static_cast<std::uint64_t>(code) : static_cast<std::uint64_t>(code);
      return number;
    }
  }
}

std::int64_t ComposeCode(ValueType type, const BinaryNumber& number)
{
  switch (type)
  {
    case ValueType::Float32:
      return ValueDomain::MakeMonotonic(
        static_cast<std::int32_t>(static_cast<std::uint32_t>(Compose(number, 23, 8))));
    case ValueType::Float64:
      return ValueDomain::MakeMonotonic(static_cast<std::int64_t>(Compose(number, 52, 11)));
    default:
    {
      if (number.Mantissa == 0)
      {
        return 0;
      }
      const bool isSigned = type == ValueType::Int64;
      const std::uint64_t limit = isSigned ? std::uint64_t{ 1 } << 63 : 0;
      const int length = 64 - __builtin_clzll(number.Mantissa);
      std::uint64_t magnitude = length + number.Exponent > (isSigned ? 63 : 64) ? limit - 1
        : number.Exponent >= 0  ? number.Mantissa << number.Exponent
        : number.Exponent > -64 ? number.Mantissa >> -number.Exponent
                                : 0;
      if (number.IsNegative)
      {
        magnitude = isSigned ? 0 - magnitude : 0;
      }
      return static_cast<std::int64_t>(magnitude);
    }
  }
}

// The number in units of 2^-shift, rounded towards zero, at most 2^62.
std::int64_t MakeFixed(const BinaryNumber& number, int shift)
{
  const int up = number.Exponent + shift;
  const int length = number.Mantissa == 0 ? 0 : 64 - __builtin_clzll(number.Mantissa);
  const std::uint64_t magnitude = length == 0 ? 0
    : length + up > 62                        ? std::uint64_t{ 1 } << 62
    : up >= 0                                 ? number.Mantissa << up
    : up > -64                                ? number.Mantissa >> -up
                                              : 0;
  const auto fixed = static_cast<std::int64_t>(magnitude);
  return number.IsNegative ? -fixed : fixed;
}

BinaryNumber DecomposeDouble(double value)
{
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof(bits));
  return Decompose(bits, 52, 11);
}

// By how many bits fixed-point numbers are finer than heights: 8; less, even below 0, where the
// isovalue would not fit otherwise.
int FindFineBits(double isovalue, int scale)
{
  const BinaryNumber number = DecomposeDouble(isovalue);
  const int length = number.Mantissa == 0 ? 0 : 64 - __builtin_clzll(number.Mantissa);
  return number.Mantissa == 0 ? 8 : std::min(8, 60 - length - number.Exponent - scale);
}

} // namespace

ValueDomain::ValueDomain(ValueType type, double isovalue, int scale)
  : Type(type)
  , Scale(scale)
  , FineBits(FindFineBits(isovalue, scale))
  , Isovalue(MakeFixed(DecomposeDouble(isovalue), scale + FineBits))
{
  DispatchValueType(type,
    [this, isovalue](auto zero)
    {
      using T = decltype(zero);
      if constexpr (!std::is_floating_point_v<T> && sizeof(T) <= 4)
      {
        this->Codes = Kind::Offsets;
        const auto threshold = FindThreshold<T>(isovalue);
        // The plus makes a number of a char.
        this->Threshold = static_cast<std::int64_t>(+threshold.value_or(T{ 0 }));
        this->Minimum = static_cast<std::int64_t>(std::numeric_limits<T>::min()) - this->Threshold;
        this->Maximum = static_cast<std::int64_t>(std::numeric_limits<T>::max()) - this->Threshold;
      }
      else
      {
        static_assert(sizeof(T) == 8 || std::is_same_v<T, float>, "others have no DecomposeCode");
        this->Codes = Kind::Bits;
        this->IsNarrow = sizeof(T) == 4;
      }
    });
}

ValueDomain ValueDomain::MakeQuantized(std::int64_t minimum, std::int64_t maximum, int scale)
{
  ValueDomain domain;
  domain.Codes = Kind::Offsets;
  domain.Type = ValueType::Int64;
  domain.Scale = scale;
  domain.Minimum = minimum;
  domain.Maximum = maximum;
  return domain;
}

std::int32_t ValueDomain::BitsToHeight(std::int64_t code) const
{
  const BinaryNumber number = DecomposeCode(this->Type, code);
  if (number.IsNan)
  {
    return 0;
  }
  const std::int64_t difference = MakeFixed(number, this->Scale + this->FineBits) - this->Isovalue;
  // Shifts by more than 12 bits exceed all heights.
  return this->FineBits >= 0
    ? ClampHeight(difference >> this->FineBits)
    : ClampHeight(std::clamp<std::int64_t>(difference, -MaximumHeight - 1, MaximumHeight + 1) *
        (std::int64_t{ 1 } << std::min(-this->FineBits, 12)));
}

std::int64_t ValueDomain::BitsFromHeight(std::int32_t height) const
{
  const std::int64_t halves = 2 * std::int64_t{ height } + 1;
  const std::int64_t fixed = this->Isovalue +
    (this->FineBits >= 1 ? halves * (std::int64_t{ 1 } << (this->FineBits - 1))
                         : halves >> std::min(1 - this->FineBits, 62));
  BinaryNumber number;
  number.IsNegative = fixed < 0;
  number.Mantissa = static_cast<std::uint64_t>(fixed < 0 ? -fixed : fixed);
  number.Exponent = -(this->Scale + this->FineBits);
  return ComposeCode(this->Type, number);
}

int ChooseScale(double typicalDistance)
{
  if (!(typicalDistance > 0) || !std::isfinite(typicalDistance))
  {
    return 0;
  }
  int exponent = 0;
  std::frexp(typicalDistance, &exponent); // typicalDistance < 2^exponent
  return std::clamp(10 - exponent, -1000, 1000);
}

} // namespace isosurface
