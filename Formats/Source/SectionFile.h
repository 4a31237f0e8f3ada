// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SectionFile_h
#define isosurface_SectionFile_h

#include "Ground/Base/FileSystem.h"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

namespace isosurface
{

/// `size` bytes of a file, from offset `begin`, as a file of their own. The file must contain them.
class SectionFile : public RandomAccessFile
{
public:
  SectionFile(std::unique_ptr<RandomAccessFile> file, std::uint64_t begin, std::uint64_t size)
    : File(std::move(file))
    , Begin(begin)
    , Size(size)
  {
  }

  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override
  {
    return this->File->Read(this->Begin + offset, size, bytes);
  }
  void Prefetch(std::uint64_t offset, std::uint64_t size) const override
  {
    this->File->Prefetch(this->Begin + offset, size);
  }
  std::uint64_t GetSize() const override { return this->Size; }
  const std::string& GetPath() const override { return this->File->GetPath(); }

private:
  std::unique_ptr<RandomAccessFile> File;
  std::uint64_t Begin;
  std::uint64_t Size;
};

} // namespace isosurface

#endif
