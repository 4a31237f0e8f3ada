// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/AttributeDomain.h"

#include "Coding/BlockCoding/ValueDomain.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace isosurface
{
namespace
{

constexpr double MaximumSteps = 1099511627776.0; ///< 2^40

std::int32_t ToBits(float value)
{
  std::int32_t bits;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

std::int64_t ToBits(double value)
{
  std::int64_t bits;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

} // namespace

AttributeDomain::AttributeDomain(ValueType type, double maximumError)
  : Type(type)
  , ValueSize(isosurface::GetValueSize(type))
  , IsNarrow(type == ValueType::Float32 && maximumError == 0)
  , MaximumError(maximumError)
  , Step(2 * maximumError * (1 - 1.0 / 1024))
{
}

double AttributeDomain::Load(const std::uint8_t* value) const
{
  if (this->Type == ValueType::Float32)
  {
    float narrow;
    std::memcpy(&narrow, value, sizeof(narrow));
    return static_cast<double>(narrow);
  }
  double wide;
  std::memcpy(&wide, value, sizeof(wide));
  return wide;
}

double AttributeDomain::Restore(std::int64_t code) const
{
  const double value = static_cast<double>(code) * this->Step;
  if (this->Type == ValueType::Float64)
  {
    return value;
  }
  // Conversion beyond the range of float is undefined.
  constexpr auto maximum = static_cast<double>(std::numeric_limits<float>::max());
  return static_cast<double>(static_cast<float>(std::clamp(value, -maximum, maximum)));
}

bool AttributeDomain::HasCode(const std::uint8_t* value) const
{
  if (this->Step == 0)
  {
    return true;
  }
  const double number = this->Load(value);
  return std::abs(number) < MaximumSteps * this->Step &&
    std::abs(this->Restore(this->ToCode(value)) - number) <= this->MaximumError;
}

std::int64_t AttributeDomain::ToCode(const std::uint8_t* value) const
{
  if (this->Step > 0)
  {
    return static_cast<std::int64_t>(std::floor(this->Load(value) / this->Step + 0.5));
  }
  if (this->Type == ValueType::Float32)
  {
    std::int32_t bits;
    std::memcpy(&bits, value, sizeof(bits));
    return ValueDomain::MakeMonotonic(bits);
  }
  std::int64_t bits;
  std::memcpy(&bits, value, sizeof(bits));
  return ValueDomain::MakeMonotonic(bits);
}

void AttributeDomain::ToValue(std::int64_t code, std::uint8_t* value) const
{
  if (this->Type == ValueType::Float32)
  {
    const auto narrow = static_cast<std::int32_t>(code);
    const std::int32_t bits = this->Step > 0 ? ToBits(static_cast<float>(this->Restore(code)))
                                             : ValueDomain::MakeMonotonic(narrow);
    std::memcpy(value, &bits, sizeof(bits));
    return;
  }
  const std::int64_t bits =
    this->Step > 0 ? ToBits(this->Restore(code)) : ValueDomain::MakeMonotonic(code);
  std::memcpy(value, &bits, sizeof(bits));
}

} // namespace isosurface
