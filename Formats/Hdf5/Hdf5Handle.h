// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Hdf5Handle_h
#define isosurface_Hdf5Handle_h

// The names of version 1.10 in every later version of the library.
#ifndef H5_USE_110_API
#  define H5_USE_110_API
#endif

#include "Formats/Source/StoredArray.h"

#include <hdf5.h>

#include <mutex>
#include <optional>
#include <string>
#include <utility>

namespace isosurface
{

/// Serialises calls of the library, which may be built without protection against threads, and keeps
/// its errors from being printed.
class Hdf5Scope
{
public:
  Hdf5Scope();
  Hdf5Scope(const Hdf5Scope&) = delete;
  Hdf5Scope& operator=(const Hdf5Scope&) = delete;
  ~Hdf5Scope();

private:
  std::lock_guard<std::recursive_mutex> Lock;
  H5E_auto2_t Printer = nullptr;
  void* Data = nullptr;
};

/// An identifier of the library, which is closed at the end.
class Hdf5Handle
{
public:
  using Closer = herr_t (*)(hid_t);

  Hdf5Handle() = default;
  Hdf5Handle(hid_t id, Closer close)
    : Id(id)
    , Close(close)
  {
  }
  Hdf5Handle(Hdf5Handle&& other) noexcept
    : Id(std::exchange(other.Id, -1))
    , Close(other.Close)
  {
  }
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept
  {
    std::swap(this->Id, other.Id);
    std::swap(this->Close, other.Close);
    return *this;
  }
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  ~Hdf5Handle()
  {
    if (this->Id >= 0)
    {
      const Hdf5Scope scope;
      this->Close(this->Id);
    }
  }

  hid_t Get() const { return this->Id; }
  bool IsOpen() const { return this->Id >= 0; }

private:
  hid_t Id = -1;
  Closer Close = nullptr;
};

/// The innermost reason of the library's last error.
std::string FindHdf5Reason();
/// The value type of the samples of an HDF5 type; nothing if there is none. Of an enumeration: that of
/// its numbers, uint8 of FALSE and TRUE.
std::optional<ValueType> FindHdf5ValueType(hid_t type);
/// "uint16", "bool", "string", ...
std::string DescribeHdf5Type(hid_t type);
/// "0 air, 1 bone": the first names of an enumeration; empty if it is none, or FALSE and TRUE.
std::string DescribeHdf5Names(hid_t type);
StoredArray::Numbers FindHdf5Shape(const Hdf5Handle& dataset);
/// Samples of a chunk on each axis; empty if the dataset has no chunks.
StoredArray::Numbers FindHdf5Chunk(const Hdf5Handle& plist, std::size_t rank);

} // namespace isosurface

#endif
