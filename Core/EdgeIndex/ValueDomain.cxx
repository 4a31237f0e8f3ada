// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/ValueDomain.h"

#include "Volume/ValueKey.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace isosurface
{
namespace
{

// Floats as integers of the same order; the inverse of itself on the bits below the sign.
template <typename Signed>
Signed MakeMonotonic(Signed bits)
{
  return bits < 0 ? static_cast<Signed>(bits ^ std::numeric_limits<Signed>::max()) : bits;
}

template <typename Signed, typename Float>
std::int64_t FloatToCode(Float value)
{
  Signed bits;
  std::memcpy(&bits, &value, sizeof(bits));
  return MakeMonotonic(bits);
}

template <typename Signed, typename Float>
Float CodeToFloat(std::int64_t code)
{
  const Signed bits = MakeMonotonic(static_cast<Signed>(code));
  Float value;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

std::int32_t ClampHeight(std::int64_t height)
{
  return static_cast<std::int32_t>(
    std::clamp<std::int64_t>(height, -ValueDomain::MostHeight, ValueDomain::MostHeight));
}

// The double nearest to a value of a type with 64-bit codes, and the value nearest to a double.
double CodeToDouble(ValueType type, std::int64_t code)
{
  switch (type)
  {
    case ValueType::Float32:
      return static_cast<double>(CodeToFloat<std::int32_t, float>(code));
    case ValueType::Float64:
      return CodeToFloat<std::int64_t, double>(code);
    case ValueType::UInt64:
      return static_cast<double>(static_cast<std::uint64_t>(code));
    default:
      return static_cast<double>(code);
  }
}

std::int64_t DoubleToCode(ValueType type, double value)
{
  constexpr double two63 = 9223372036854775808.0;
  switch (type)
  {
    case ValueType::Float32:
      // Beyond the range of float the conversion is undefined.
      return FloatToCode<std::int32_t>(static_cast<float>(
        std::clamp(value, static_cast<double>(std::numeric_limits<float>::lowest()),
          static_cast<double>(std::numeric_limits<float>::max()))));
    case ValueType::Float64:
      return FloatToCode<std::int64_t>(value);
    case ValueType::UInt64:
      return value < 0       ? 0
        : value >= 2 * two63 ? -1
                             : static_cast<std::int64_t>(static_cast<std::uint64_t>(value));
    default:
      return value < -two63 ? std::numeric_limits<std::int64_t>::min()
        : value >= two63    ? std::numeric_limits<std::int64_t>::max()
                            : static_cast<std::int64_t>(value);
  }
}

} // namespace

ValueDomain::ValueDomain(ValueType type, double isovalue, int scale)
  : Type(type)
  , Scale(scale)
  , Isovalue(isovalue)
  , Unit(std::ldexp(1.0, -scale))
{
  DispatchValueType(type,
    [this, isovalue](auto zero)
    {
      using T = decltype(zero);
      if constexpr (!std::is_floating_point_v<T> && sizeof(T) <= 4)
      {
        this->Codes = Kind::Offsets;
        const auto threshold = FindThreshold<T>(isovalue);
        this->Threshold = static_cast<std::int64_t>(threshold.value_or(0));
        this->Least = static_cast<std::int64_t>(std::numeric_limits<T>::min()) - this->Threshold;
        this->Greatest = static_cast<std::int64_t>(std::numeric_limits<T>::max()) - this->Threshold;
      }
      else
      {
        this->Codes = Kind::Bits;
        this->Width = sizeof(T) == 4 ? 32 : 64;
      }
    });
}

ValueDomain ValueDomain::MakeQuantized(std::int64_t least, std::int64_t greatest, int scale)
{
  ValueDomain domain;
  domain.Codes = Kind::Offsets;
  domain.Type = ValueType::Int64;
  domain.Scale = scale;
  domain.Least = least;
  domain.Greatest = greatest;
  return domain;
}

std::int64_t ValueDomain::ToCode(const void* value) const
{
  return DispatchValueType(this->Type,
    [this, value](auto zero) -> std::int64_t
    {
      using T = decltype(zero);
      T typed;
      std::memcpy(&typed, value, sizeof(typed));
      if constexpr (std::is_same_v<T, float>)
      {
        return FloatToCode<std::int32_t>(typed);
      }
      else if constexpr (std::is_same_v<T, double>)
      {
        return FloatToCode<std::int64_t>(typed);
      }
      else
      {
        return static_cast<std::int64_t>(typed) - this->Threshold;
      }
    });
}

void ValueDomain::ToValue(std::int64_t code, void* value) const
{
  DispatchValueType(this->Type,
    [this, code, value](auto zero)
    {
      using T = decltype(zero);
      T typed;
      if constexpr (std::is_same_v<T, float>)
      {
        typed = CodeToFloat<std::int32_t, float>(code);
      }
      else if constexpr (std::is_same_v<T, double>)
      {
        typed = CodeToFloat<std::int64_t, double>(code);
      }
      else
      {
        typed = static_cast<T>(code + this->Threshold);
      }
      std::memcpy(value, &typed, sizeof(typed));
    });
}

std::int32_t ValueDomain::ToHeight(std::int64_t code) const
{
  if (this->Codes == Kind::Offsets)
  {
    const std::int64_t middle = 2 * code + 1; // in halves
    return ClampHeight(this->Scale >= 1 ? middle * (std::int64_t(1) << (this->Scale - 1))
                                        : middle >> (1 - this->Scale));
  }
  const double steps = (CodeToDouble(this->Type, code) - this->Isovalue) / this->Unit;
  constexpr auto most = static_cast<double>(MostHeight);
  return steps >= most ? MostHeight
    : steps <= -most   ? -MostHeight
    : steps == steps   ? static_cast<std::int32_t>(std::floor(steps))
                       : 0;
}

std::int64_t ValueDomain::FromHeight(std::int32_t height, int& quarter) const
{
  quarter = 0;
  if (this->Codes == Kind::Offsets)
  {
    if (this->Scale <= 0)
    {
      return static_cast<std::int64_t>(height) * (std::int64_t(1) << -this->Scale);
    }
    quarter = (this->Scale >= 2 ? height >> (this->Scale - 2) : height << 1) & 3;
    return height >> this->Scale;
  }
  return DoubleToCode(this->Type, this->Isovalue + (height + 0.5) * this->Unit);
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
