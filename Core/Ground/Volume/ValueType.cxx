// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/ValueType.h"

#include "Ground/Base/EnumeratorNames.h"

#include <type_traits>

namespace isosurface
{

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

bool IsFloatingType(ValueType type)
{
  return DispatchValueType(
    type, [](auto zero) { return std::is_floating_point_v<decltype(zero)>; });
}

const char* GetValueTypeName(ValueType type)
{
  switch (type)
  {
    case ValueType::Int8:
      return "int8";
    case ValueType::UInt8:
      return "uint8";
    case ValueType::Int16:
      return "int16";
    case ValueType::UInt16:
      return "uint16";
    case ValueType::Int32:
      return "int32";
    case ValueType::UInt32:
      return "uint32";
    case ValueType::Int64:
      return "int64";
    case ValueType::UInt64:
      return "uint64";
    case ValueType::Float32:
      return "float32";
    case ValueType::Float64:
      return "float64";
  }
  return nullptr;
}

std::optional<ValueType> FindValueType(const std::string& name)
{
  return FindEnumerator(name, GetValueTypeName);
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
