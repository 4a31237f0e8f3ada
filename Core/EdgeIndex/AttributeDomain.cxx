// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/AttributeDomain.h"

#include "EdgeIndex/AttributeCoder.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

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
  return DispatchValueType(this->Type,
    [value](auto zero) -> std::int64_t
    {
      using T = decltype(zero);
      if constexpr (std::is_floating_point_v<T>)
      {
        std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t> bits;
        std::memcpy(&bits, value, sizeof(bits));
        return MakeMonotonic(bits);
      }
      else
      {
        T typed;
        std::memcpy(&typed, value, sizeof(typed));
        return static_cast<std::int64_t>(typed);
      }
    });
}

void AttributeDomain::ToValue(std::int64_t code, std::uint8_t* value) const
{
  if (this->Step > 0)
  {
    const double number = this->Restore(code);
    if (this->Type == ValueType::Float32)
    {
      const auto narrow = static_cast<float>(number);
      std::memcpy(value, &narrow, sizeof(narrow));
      return;
    }
    std::memcpy(value, &number, sizeof(number));
    return;
  }
  DispatchValueType(this->Type,
    [code, value](auto zero)
    {
      using T = decltype(zero);
      if constexpr (std::is_floating_point_v<T>)
      {
        using Signed = std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t>;
        const Signed bits = MakeMonotonic(static_cast<Signed>(code));
        std::memcpy(value, &bits, sizeof(bits));
      }
      else
      {
        const T typed = static_cast<T>(code);
        std::memcpy(value, &typed, sizeof(typed));
      }
    });
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
