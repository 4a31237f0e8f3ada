// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BinaryHeader_h
#define isosurface_BinaryHeader_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

namespace isosurface
{

/// The first bytes of a file, or of what a gzip stream in it inflates to.
class BinaryHeader
{
public:
  /// Reads `size` bytes. Errors: Corrupt if there are fewer.
  static Result<BinaryHeader> Open(FileSystem& files, const std::string& path, std::size_t size);

  bool IsGzip() const { return this->Gzip; }
  const std::string& GetPath() const { return this->Path; }
  void SetBigEndian(bool isBigEndian) { this->BigEndian = isBigEndian; }
  bool IsBigEndian() const { return this->BigEndian; }

  /// The number at an offset, which must be within the header.
  template <typename T>
  T Get(std::size_t offset) const
  {
    static_assert(std::is_arithmetic_v<T>);
    std::array<std::uint8_t, sizeof(T)> bytes;
    std::copy_n(this->Bytes.data() + offset, sizeof(T), bytes.begin());
    if (this->BigEndian)
    {
      std::reverse(bytes.begin(), bytes.end());
    }
    T value;
    std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }
  bool HasText(std::size_t offset, const std::string& text) const
  {
    return std::equal(text.begin(), text.end(),
      this->Bytes.begin() + static_cast<std::ptrdiff_t>(offset),
      [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
  }

  /// An error that names the file.
  Status MakeError(StatusCode code, const std::string& reason) const
  {
    return Status(code, this->Path + ": cannot be read: " + reason);
  }

private:
  std::string Path;
  std::vector<std::uint8_t> Bytes;
  bool Gzip = false;
  bool BigEndian = false;
};

} // namespace isosurface

#endif
