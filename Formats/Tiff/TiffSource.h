// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffSource_h
#define isosurface_TiffSource_h

#include "Formats/Tiff/TiffFile.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/BoxSource.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * A stack of TIFF pages in one or several files: each page is a slice, with x along the rows and y
 * from the first row on. Only the last file stays open, so there may be any number of files.
 *
 * Cost of a box: all strips or tiles that it touches are read and decoded.
 */
class TiffSource : public BoxSource
{
public:
  /// Reads the directories of all pages of all files, which must have the same format. Errors name
  /// the file and the page. `files` must outlive the source.
  static Result<std::unique_ptr<TiffSource>> Open(
    FileSystem& files, const std::vector<std::string>& paths);

  ValueType GetType() const { return this->Format.Type; }

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  std::uint64_t GetHeldBytes() const override;
  /// Of one page, so many strips or tiles that a block needs few chunks of it.
  std::optional<Index3> GetChunk() const override { return this->Chunk; }
  Result<BoxSamples> Read(const VertexBox& box) override;

private:
  struct Slice
  {
    std::size_t File;
    TiffPage Page;
  };

  TiffSource(FileSystem& files, std::vector<std::string> paths)
    : Files(files)
    , Paths(std::move(paths))
  {
  }
  Status FindSlices();
  Status OpenFile(std::size_t number);

  FileSystem& Files;
  std::vector<std::string> Paths;
  std::vector<Slice> Slices;
  TiffFormat Format;
  VertexBox Box;
  Index3 Chunk = { 1, 1, 1 };
  std::uint64_t ScratchBytes = 0;
  std::size_t OpenNumber = 0;
  std::unique_ptr<TiffFile> Opened;
};

} // namespace isosurface

#endif
