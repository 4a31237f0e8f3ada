// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffArray_h
#define isosurface_TiffArray_h

#include "Formats/Source/StoredArray.h"
#include "Formats/Tiff/TiffFile.h"
#include "Ground/Base/FileSystem.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// A page of one of several files.
struct TiffSlice
{
  std::size_t File = 0;
  TiffPage Page;
};

/**
 * A stack of TIFF pages of one format in one or several files, as an array of slices, rows, columns and,
 * if a pixel has several, samples. Only the last file stays open, so there may be any number of files.
 *
 * Cost of a box: all strips or tiles that it touches are read and decoded.
 */
class TiffArray : public StoredArray
{
public:
  /// `format` is that of all slices; a slice of another one is an error when it is read. `isOffset`:
  /// whether samples of uint16 are those of int16, increased by 32768. Errors: of the first slice.
  /// `files` must outlive the array.
  static Result<std::shared_ptr<TiffArray>> Open(FileSystem& files,
    std::shared_ptr<const std::vector<std::string>> paths, std::vector<TiffSlice> slices,
    const TiffFormat& format, bool isOffset);

  const std::string& GetName() const override { return this->Paths->front(); }
  const Numbers& GetShape() const override { return this->Shape; }
  ValueType GetType() const override
  {
    return this->IsOffset ? ValueType::Int16 : this->Format.Type;
  }
  /// The number of strips or tiles of one page by which a block needs few chunks.
  Numbers GetChunk() const override { return this->Chunk; }
  bool DecodesInParallel() const override { return true; }
  std::uint64_t GetHeldBytes() const override;
  Status Read(const Numbers& low, const Numbers& size, std::uint8_t* to) override;

private:
  TiffArray(FileSystem& files, std::shared_ptr<const std::vector<std::string>> paths,
    std::vector<TiffSlice> slices, const TiffFormat& format, bool isOffset);
  Status OpenFile(std::size_t number);

  FileSystem& Files;
  std::shared_ptr<const std::vector<std::string>> Paths;
  std::vector<TiffSlice> Slices;
  TiffFormat Format;
  bool IsOffset;
  Numbers Shape;
  Numbers Chunk;
  std::uint64_t ScratchBytes = 0;
  std::size_t OpenNumber = 0;
  std::unique_ptr<TiffFile> Opened;
};

} // namespace isosurface

#endif
