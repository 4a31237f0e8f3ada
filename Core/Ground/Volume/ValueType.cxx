// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/ValueType.h"

#include <array>

namespace isosurface
{
namespace
{
constexpr std::array<const char*, 10> Names = { "int8", "uint8", "int16", "uint16", "int32",
  "uint32", "int64", "uint64", "float32", "float64" };
}

std::size_t GetValueSize(ValueType type)
{
  return DispatchValueType(type, [](auto zero) { return sizeof(zero); });
}

std::uint64_t SumValueSizes(const std::vector<ValueType>& types)
{
  std::uint64_t bytes = 0;
  for (const ValueType type : types)
  {
    bytes += GetValueSize(type);
  }
  return bytes;
}

const char* GetValueTypeName(ValueType type)
{
  return Names[static_cast<std::size_t>(type)];
}

std::optional<ValueType> FindValueType(const std::string& name)
{
  for (std::size_t index = 0; index < Names.size(); ++index)
  {
    if (name == Names[index])
    {
      return static_cast<ValueType>(index);
    }
  }
  return std::nullopt;
}

std::optional<ValueType> FindIntegerType(std::size_t size, bool isSigned)
{
  switch (size)
  {
    case 1:
      return isSigned ? ValueType::Int8 : ValueType::UInt8;
    case 2:
      return isSigned ? ValueType::Int16 : ValueType::UInt16;
    case 4:
      return isSigned ? ValueType::Int32 : ValueType::UInt32;
    case 8:
      return isSigned ? ValueType::Int64 : ValueType::UInt64;
    default:
      return std::nullopt;
  }
}

} // namespace isosurface
