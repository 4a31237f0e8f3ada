// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Hdf5/Hdf5Handle.h"

#include <algorithm>
#include <cstdlib>
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
      return "enumeration";
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
