// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GzipFile_h
#define isosurface_GzipFile_h

#include "Base/FileSystem.h"

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * What a gzip or zlib stream inflates to, read at any offset. The first pass inflates front to back
 * and notes places where inflating can begin again, at most 1024, 4 MiB apart or more; so a read
 * elsewhere inflates what lies between such a place and its end, but never all from the beginning.
 *
 * Memory: 32 KiB a place. Several gzip members in a row are one file. A damaged stream is Corrupt,
 * as is one that ends too early; the stream's own checksums are checked by reading front to back.
 * Several threads may read; they wait for each other.
 *
 * Source: the method is that of M. Adler's zran (an example of zlib, 2005).
 */
class GzipFile : public RandomAccessFile
{
public:
  /// The stream begins at `begin` of the file; `size` bytes of what it inflates to are wanted.
  GzipFile(std::unique_ptr<RandomAccessFile> file, std::uint64_t begin, std::uint64_t size);
  ~GzipFile() override;

  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override;
  std::uint64_t GetSize() const override { return this->Size; }
  const std::string& GetPath() const override { return this->File->GetPath(); }

  /// The most memory that such an object takes, of which `size` bytes are wanted.
  static std::uint64_t GetHeldBytes(std::uint64_t size);

private:
  /// Where inflating can begin again: between two blocks of the deflate format.
  struct Place
  {
    std::uint64_t In = 0;
    std::uint64_t Out = 0;
    int Bits = 0; ///< of the byte before In that belong to the next block
    std::vector<std::uint8_t> Window;
  };
  class Inflater;

  Status Seek(std::uint64_t offset) const;
  void NotePlace() const;

  std::unique_ptr<RandomAccessFile> File;
  std::uint64_t Begin;
  std::uint64_t Size;
  std::uint64_t Spacing;
  mutable std::mutex Mutex;
  mutable std::vector<Place> Places; ///< by increasing Out
  mutable std::unique_ptr<Inflater> State;
};

} // namespace isosurface

#endif
