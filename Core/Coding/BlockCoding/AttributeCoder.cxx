// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/AttributeCoder.h"

#include "Coding/BlockCoding/ValueDomain.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace isosurface
{
namespace
{

constexpr int MaximumSquaredQuarters = 6; ///< four times the squared distance of middles

// The row of edges along `other` near an edge along `axis`.
AttributeNeighbors::Row MakeRow(int axis, int plane, int dy, int other)
{
  AttributeNeighbors::Row row;
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
    if (quarters > 0 && quarters <= MaximumSquaredQuarters)
    {
      row.Near |= 1u << (dx + 2);
      row.Weights[static_cast<std::size_t>(dx + 2)] = 4096 / (quarters * quarters);
    }
  }
  return row;
}

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

const AttributeNeighbors& AttributeNeighbors::Get()
{
  static const AttributeNeighbors neighbors;
  return neighbors;
}

AttributeNeighbors::AttributeNeighbors()
{
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int plane = 0; plane < 2; ++plane)
    {
      for (int line = 0; line < 9; ++line)
      {
        const Row row = MakeRow(axis, plane, line / 3 - 1, line % 3);
        if (row.Near != 0)
        {
          this->Rows[static_cast<std::size_t>(axis)].push_back(row);
        }
      }
    }
  }
}

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
