// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Hdf5/Hdf5Handle.h"

#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <vector>

namespace isosurface
{
namespace
{

std::recursive_mutex& GetLibraryMutex()
{
  static std::recursive_mutex mutex;
  return mutex;
}

/// A name of an enumeration.
std::string FindMemberName(hid_t type, unsigned number)
{
  char* const found = ::H5Tget_member_name(type, number);
  const std::string name = found ? found : "";
  ::H5free_memory(found);
  return name;
}

/// The number that a name of an enumeration stands for.
long long FindMemberNumber(hid_t type, unsigned number)
{
  const Hdf5Handle base(::H5Tget_super(type), ::H5Tclose);
  constexpr std::size_t largest = 16; // of integers of the library
  std::uint8_t bytes[largest] = {};
  long long value = 0;
  if (!base.IsOpen() || ::H5Tget_size(base.Get()) > largest ||
    ::H5Tget_member_value(type, number, bytes) < 0 ||
    ::H5Tconvert(base.Get(), H5T_NATIVE_LLONG, 1, bytes, nullptr, H5P_DEFAULT) < 0)
  {
    return -1;
  }
  std::memcpy(&value, bytes, sizeof(value));
  return value;
}

/// The booleans of h5py, PyTables and others: an enumeration of FALSE and TRUE.
bool IsBool(hid_t type)
{
  if (::H5Tget_class(type) != H5T_ENUM || ::H5Tget_nmembers(type) != 2)
  {
    return false;
  }
  for (unsigned number = 0; number < 2; ++number)
  {
    const long long value = FindMemberNumber(type, number);
    if ((value != 0 && value != 1) ||
      LowerText(FindMemberName(type, number)) != (value == 0 ? "false" : "true"))
    {
      return false;
    }
  }
  return true;
}

/// Damaged files leave memory in the library that it cannot free. When the process ends, it would say
/// "infinite loop closing library", if it may print errors then.
void KeepTheEndQuiet()
{
  ::H5open(); // so that it ends after what is registered here
  std::atexit([] { ::H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); });
}

} // namespace

Hdf5Scope::Hdf5Scope()
  : Lock(GetLibraryMutex())
{
  static std::once_flag isQuiet;
  std::call_once(isQuiet, KeepTheEndQuiet);
  ::H5Eget_auto2(H5E_DEFAULT, &this->Printer, &this->Data);
  ::H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Hdf5Scope::~Hdf5Scope()
{
  ::H5Eset_auto2(H5E_DEFAULT, this->Printer, this->Data);
}

std::string FindHdf5Reason()
{
  std::string reason;
  ::H5Ewalk2(
    H5E_DEFAULT, H5E_WALK_UPWARD,
    [](unsigned, const H5E_error2_t* error, void* to) -> herr_t
    {
      auto* text = static_cast<std::string*>(to);
      // The library looks for a missing filter in a folder, and then says that there is none.
      if (error->desc && (text->empty() || std::string(error->desc).find("required filter") == 0))
      {
        *text = error->desc;
      }
      return 0;
    },
    &reason);
  return reason.empty() ? "the library gives no reason" : reason;
}

std::optional<ValueType> FindHdf5ValueType(hid_t type)
{
  const std::size_t size = ::H5Tget_size(type);
  const H5T_class_t kind = ::H5Tget_class(type);
  if (kind == H5T_ENUM)
  {
    const Hdf5Handle base(::H5Tget_super(type), ::H5Tclose);
    return IsBool(type) ? ValueType::UInt8 : FindHdf5ValueType(base.Get());
  }
  if (kind == H5T_INTEGER)
  {
    return FindIntegerType(size, ::H5Tget_sign(type) == H5T_SGN_2);
  }
  if (kind == H5T_FLOAT && (size == 2 || size == 4 || size == 8))
  {
    return size == 8 ? ValueType::Float64 : ValueType::Float32;
  }
  return std::nullopt;
}

std::string DescribeHdf5Type(hid_t type)
{
  const std::string bits = std::to_string(8 * ::H5Tget_size(type));
  switch (::H5Tget_class(type))
  {
    case H5T_INTEGER:
      return (::H5Tget_sign(type) == H5T_SGN_2 ? "int" : "uint") + bits;
    case H5T_FLOAT:
      return "float" + bits;
    case H5T_STRING:
      return "string";
    case H5T_COMPOUND:
      return "compound";
    case H5T_ENUM:
      return IsBool(type) ? "bool" : "enumeration of " + bits + " bits";
    case H5T_REFERENCE:
      return "reference";
    case H5T_VLEN:
      return "sequences of variable length";
    case H5T_ARRAY:
      return "arrays";
    default:
      return "opaque";
  }
}

std::string DescribeHdf5Names(hid_t type)
{
  if (::H5Tget_class(type) != H5T_ENUM || IsBool(type))
  {
    return "";
  }
  constexpr int most = 16;
  const int count = ::H5Tget_nmembers(type);
  std::string text;
  for (int number = 0; number < std::min(count, most); ++number)
  {
    const auto member = static_cast<unsigned>(number);
    text += (number == 0 ? "" : ", ") + std::to_string(FindMemberNumber(type, member)) + " " +
      FindMemberName(type, member);
  }
  return text + (count > most ? ", ..." : "");
}

StoredArray::Numbers FindHdf5Shape(const Hdf5Handle& dataset)
{
  const Hdf5Handle space(::H5Dget_space(dataset.Get()), ::H5Sclose);
  const int rank = ::H5Sget_simple_extent_ndims(space.Get());
  std::vector<hsize_t> sizes(static_cast<std::size_t>(std::max(rank, 0)));
  if (rank > 0)
  {
    ::H5Sget_simple_extent_dims(space.Get(), sizes.data(), nullptr);
  }
  StoredArray::Numbers shape;
  for (const hsize_t size : sizes)
  {
    constexpr auto most = static_cast<hsize_t>(std::numeric_limits<std::int64_t>::max());
    shape.push_back(static_cast<std::int64_t>(std::min(size, most)));
  }
  return shape;
}

StoredArray::Numbers FindHdf5Chunk(const Hdf5Handle& plist, std::size_t rank)
{
  if (rank == 0 || ::H5Pget_layout(plist.Get()) != H5D_CHUNKED)
  {
    return {};
  }
  std::vector<hsize_t> sizes(rank, 1);
  ::H5Pget_chunk(plist.Get(), static_cast<int>(rank), sizes.data());
  return { sizes.begin(), sizes.end() };
}

} // namespace isosurface
