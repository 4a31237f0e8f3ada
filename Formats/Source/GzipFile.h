// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GzipFile_h
#define isosurface_GzipFile_h

#include "Ground/Base/FileSystem.h"

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * Reads the uncompressed bytes of a gzip or zlib stream at any offset. The first pass records
 * places at which inflating can start: at most 1024, at least 4 MiB apart. A later read starts at
 * the place before its offset instead of the beginning of the stream.
 *
 * Several gzip members are one file. Errors: Corrupt (damaged, truncated). The checksums of the
 * stream are checked when it is read from front to back. Several threads may read, one at a time.
 * Memory: 32 KiB for each place.
 *
 * Source: the method of M. Adler's zran (an example of zlib, 2005).
 */
class GzipFile : public RandomAccessFile
{
public:
  /// The stream begins at offset `begin` of the file. `size`: the uncompressed bytes to be read. If
  /// `isWhole`, it is Corrupt to have more; it is seen when the stream is read from front to back.
  GzipFile(std::unique_ptr<RandomAccessFile> file, std::uint64_t begin, std::uint64_t size,
    bool isWhole = false);
  ~GzipFile() override;

  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override;
  std::uint64_t GetSize() const override { return this->Size; }
  const std::string& GetPath() const override { return this->File->GetPath(); }

  /// The maximum memory of an object for `size` uncompressed bytes.
  static std::uint64_t GetHeldBytes(std::uint64_t size);

private:
  /// A place at which inflating can start, between two blocks of the deflate format.
  struct Place
  {
    std::uint64_t In = 0;  ///< offset in the file
    std::uint64_t Out = 0; ///< offset in the uncompressed bytes
    int Bits = 0;          ///< of the byte before In that belong to the next block
    std::vector<std::uint8_t> Window;
  };
  class Inflater;

  Status Seek(std::uint64_t offset) const;
  void NotePlace() const;

  std::unique_ptr<RandomAccessFile> File;
  std::uint64_t Begin;
  std::uint64_t Size;
  bool IsWhole;
  std::uint64_t Spacing;
  mutable std::mutex Mutex;
  mutable std::vector<Place> Places; ///< by increasing Out
  mutable std::unique_ptr<Inflater> State;
};

} // namespace isosurface

#endif
