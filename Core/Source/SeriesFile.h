// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SeriesFile_h
#define isosurface_SeriesFile_h

#include "Base/FileSystem.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * A series of files that each hold an equal number of bytes, as if they were one. A file is opened
 * when it is read, and the last one read stays open; so there may be any number of them. One
 * thread at a time may read.
 */
class SeriesFile : public RandomAccessFile
{
public:
  /// Of every file the `size` bytes from `begin` on.
  SeriesFile(
    FileSystem& files, std::vector<std::string> paths, std::uint64_t begin, std::uint64_t size);

  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override;
  std::uint64_t GetSize() const override { return this->Paths.size() * this->Size; }
  const std::string& GetPath() const override { return this->Paths.front(); }

private:
  FileSystem& Files;
  std::vector<std::string> Paths;
  std::uint64_t Begin;
  std::uint64_t Size;
  mutable std::size_t OpenNumber = 0;
  mutable std::unique_ptr<RandomAccessFile> OpenFile;
};

} // namespace isosurface

#endif
