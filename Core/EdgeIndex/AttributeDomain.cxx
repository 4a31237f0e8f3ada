// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/AttributeDomain.h"

#include "EdgeIndex/AttributeCoder.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace isosurface
{
namespace
{

constexpr double MostSteps = 1099511627776.0; ///< 2^40

template <typename Signed>
Signed MakeMonotonic(Signed bits)
{
  return bits < 0 ? static_cast<Signed>(bits ^ std::numeric_limits<Signed>::max()) : bits;
}

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

AttributeDomain::AttributeDomain(const EdgeIndexAttribute& attribute)
  : Type(attribute.Type)
  , ValueSize(isosurface::GetValueSize(attribute.Type))
  , IsNarrow(attribute.Type == ValueType::Float32 && attribute.MaximumError == 0)
  , MaximumError(attribute.MaximumError)
  , Step(2 * attribute.MaximumError * (1 - 1.0 / 1024))
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
  // Beyond the range of float the conversion is undefined.
  constexpr auto most = static_cast<double>(std::numeric_limits<float>::max());
  return static_cast<double>(static_cast<float>(value < -most ? -most
      : value > most                                          ? most
                                                              : value));
}

bool AttributeDomain::HasCode(const std::uint8_t* value) const
{
  if (this->Step == 0)
  {
    return true;
  }
  const double number = this->Load(value);
  return std::abs(number) < MostSteps * this->Step &&
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
    return MakeMonotonic(bits);
  }
  std::int64_t bits;
  std::memcpy(&bits, value, sizeof(bits));
  return MakeMonotonic(bits);
}

void AttributeDomain::ToValue(std::int64_t code, std::uint8_t* value) const
{
  if (this->Type == ValueType::Float32)
  {
    const auto narrow = static_cast<std::int32_t>(code);
    const std::int32_t bits =
      this->Step > 0 ? ToBits(static_cast<float>(this->Restore(code))) : MakeMonotonic(narrow);
    std::memcpy(value, &bits, sizeof(bits));
    return;
  }
  const std::int64_t bits = this->Step > 0 ? ToBits(this->Restore(code)) : MakeMonotonic(code);
  std::memcpy(value, &bits, sizeof(bits));
}

AttributeNeighbors::AttributeNeighbors()
{
  constexpr int mostSquaredQuarters = 6;
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int plane = 0; plane < 2; ++plane)
    {
      for (int dy = -1; dy <= 1; ++dy)
      {
        for (int other = 0; other < 3; ++other)
        {
          Row row;
          row.Plane = static_cast<std::size_t>(plane);
          row.Axis = static_cast<std::size_t>(other);
          row.Y = dy;
          for (int dx = -2; dx <= 2; ++dx)
          {
            const int step[3] = { dx, dy, -plane };
            int quarters = 0;
            for (int n = 0; n < 3; ++n)
            {
              const int halves = 2 * step[n] - (n == axis ? 1 : 0) + (n == other ? 1 : 0);
              quarters += halves * halves;
            }
            if (quarters > 0 && quarters <= mostSquaredQuarters)
            {
              row.Near |= 1u << (dx + 2);
              row.Weights[static_cast<std::size_t>(dx + 2)] = 4096 / (quarters * quarters);
            }
          }
          if (row.Near != 0)
          {
            this->Rows[static_cast<std::size_t>(axis)].push_back(row);
          }
        }
      }
    }
  }
}

} // namespace isosurface
