// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ValueType_h
#define isosurface_ValueType_h

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// The type of a volume's samples. The numbers are part of the file format.
enum class ValueType : std::uint8_t
{
  Int8 = 0,
  UInt8 = 1,
  Int16 = 2,
  UInt16 = 3,
  Int32 = 4,
  UInt32 = 5,
  Int64 = 6,
  UInt64 = 7,
  Float32 = 8,
  Float64 = 9
};

/// Bytes of one sample.
std::size_t GetValueSize(ValueType type);
std::uint64_t SumValueSizes(const std::vector<ValueType>& types);

bool IsFloatingType(ValueType type);
/// The type's name in file headers: "int8", "uint8", ... "float32", "float64". Null: no type has this
/// number.
const char* GetValueTypeName(ValueType type);
/// The type of that name; nothing if there is none.
std::optional<ValueType> FindValueType(const std::string& name);
/// The type of integers of `size` bytes (1, 2, 4 or 8); nothing for other sizes.
std::optional<ValueType> FindIntegerType(std::size_t size, bool isSigned);

template <typename T>
struct ValueTypeOf;
// clang-format off
template <> struct ValueTypeOf<std::int8_t> { static constexpr ValueType Value = ValueType::Int8; };
template <> struct ValueTypeOf<std::uint8_t> { static constexpr ValueType Value = ValueType::UInt8; };
template <> struct ValueTypeOf<std::int16_t> { static constexpr ValueType Value = ValueType::Int16; };
template <> struct ValueTypeOf<std::uint16_t> { static constexpr ValueType Value = ValueType::UInt16; };
template <> struct ValueTypeOf<std::int32_t> { static constexpr ValueType Value = ValueType::Int32; };
template <> struct ValueTypeOf<std::uint32_t> { static constexpr ValueType Value = ValueType::UInt32; };
template <> struct ValueTypeOf<std::int64_t> { static constexpr ValueType Value = ValueType::Int64; };
template <> struct ValueTypeOf<std::uint64_t> { static constexpr ValueType Value = ValueType::UInt64; };
template <> struct ValueTypeOf<float> { static constexpr ValueType Value = ValueType::Float32; };
template <> struct ValueTypeOf<double> { static constexpr ValueType Value = ValueType::Float64; };
// clang-format on

/**
 * Calls functor(T{}) with a zero of the C++ type that `type` names, and returns the result.
 */
template <typename Functor>
decltype(auto) DispatchValueType(ValueType type, Functor&& functor)
{
  switch (type)
  {
    case ValueType::Int8:
      return functor(std::int8_t{});
    case ValueType::UInt8:
      return functor(std::uint8_t{});
    case ValueType::Int16:
      return functor(std::int16_t{});
    case ValueType::UInt16:
      return functor(std::uint16_t{});
    case ValueType::Int32:
      return functor(std::int32_t{});
    case ValueType::UInt32:
      return functor(std::uint32_t{});
    case ValueType::Int64:
      return functor(std::int64_t{});
    case ValueType::UInt64:
      return functor(std::uint64_t{});
    case ValueType::Float32:
      return functor(float{});
    case ValueType::Float64:
      break;
  }
  return functor(double{}); // not a default case: the compiler shall name a type that is missing
}

} // namespace isosurface

#endif
