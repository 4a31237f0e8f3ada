// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffHandle_h
#define isosurface_TiffHandle_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

#include <tiffio.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

namespace isosurface
{

/// libtiff's handle of a file, which it reads through our functions. Errors are kept, not printed.
struct TiffHandle
{
  /// The maximum size of the tables of libtiff's codecs.
  static constexpr std::uint64_t MaximumTableSize = std::uint64_t{ 64 } << 20;

  /// Errors: Corrupt (no TIFF file), IoError, OutOfMemory.
  static Result<std::unique_ptr<TiffHandle>> Open(std::unique_ptr<RandomAccessFile> file);
  TiffHandle() = default;
  TiffHandle(const TiffHandle&) = delete;
  TiffHandle& operator=(const TiffHandle&) = delete;
  ~TiffHandle();

  /// A field of the current directory.
  template <typename T>
  T Get(std::uint32_t tag, T otherwise) const
  {
    T value = otherwise;
    return ::TIFFGetFieldDefaulted(this->Tiff, tag, &value) == 1 ? value : otherwise;
  }

  /// A field of the current directory that libtiff does not know, and how many values or letters it has;
  /// null if there is none.
  std::pair<std::uint32_t, const void*> FindUnknown(std::uint32_t tag) const;

  std::unique_ptr<RandomAccessFile> File;
  std::uint64_t Position = 0;
  Status Failure;     ///< the first error of the file
  std::string Reason; ///< the first error of libtiff
  ::TIFF* Tiff = nullptr;
};

} // namespace isosurface

#endif
