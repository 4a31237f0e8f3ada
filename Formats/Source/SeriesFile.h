// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SeriesFile_h
#define isosurface_SeriesFile_h

#include "Ground/Base/FileSystem.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * A series of files of equal size as if they were one file. A file is opened when it is read, and
 * only the last one stays open, so there may be any number of files. One thread at a time may read.
 */
class SeriesFile : public RandomAccessFile
{
public:
  /// Opens one file of the series. The result must have `size` bytes.
  using Opener = std::function<Result<std::unique_ptr<RandomAccessFile>>(const std::string& path)>;

  SeriesFile(Opener open, std::vector<std::string> paths, std::uint64_t size);

  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override;
  std::uint64_t GetSize() const override { return this->Paths.size() * this->Size; }
  const std::string& GetPath() const override { return this->Paths.front(); }

private:
  Opener Open;
  std::vector<std::string> Paths;
  std::uint64_t Size;
  mutable std::size_t OpenNumber = 0;
  mutable std::unique_ptr<RandomAccessFile> OpenFile;
};

} // namespace isosurface

#endif
