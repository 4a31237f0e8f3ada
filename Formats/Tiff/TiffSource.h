// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffSource_h
#define isosurface_TiffSource_h

#include "Formats/Tiff/TiffFile.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/BoxSource.h"

#include <array>
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
 * from the first row on. Only the last file stays open, so there may be any number of files. Of a
 * pyramid it may be a coarser level, whose slices are as far apart as its rows (of a level with half
 * of the rows every second page) unless few would be left.
 *
 * Cost of a box: all strips or tiles that it touches are read and decoded.
 */
class TiffSource : public BoxSource
{
public:
  /// Reads the directories of all pages of all files, which must have the same format. Errors name
  /// the file and the page. `files` must outlive the source. `vertices`: VolumeChoice::Vertices.
  static Result<std::unique_ptr<TiffSource>> Open(
    FileSystem& files, const std::vector<std::string>& paths, std::int64_t vertices = 0);

  ValueType GetType() const { return this->Format.Type; }
  /// The level of the pyramid; 0: the pages themselves.
  int GetLevel() const { return this->Level; }
  /// How many samples of the pages are between two of the level, on each axis.
  const std::array<double, 3>& GetSteps() const { return this->Steps; }

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  std::uint64_t GetHeldBytes() const override;
  /// Of one page, so many strips or tiles that a block needs few chunks of it.
  std::optional<Index3> GetChunk() const override { return this->Chunk; }
  bool DecodesInParallel() const override { return true; }
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
  /// Finds the slices of all levels.
  Status FindSlices();
  /// The format of a level, from 1; nothing if its first page cannot be one of a smaller image.
  std::optional<TiffFormat> FindFormatOfLevel(std::size_t level);
  /// Goes to the finest level of at most so many vertices, or the coarsest.
  Status ChooseLevel(std::int64_t vertices);
  Status FindBox();
  Status OpenFile(std::size_t number);

  FileSystem& Files;
  std::vector<std::string> Paths;
  std::vector<Slice> Slices;
  std::vector<std::vector<Slice>> SmallerSlices; ///< by level, from 1; until one is chosen
  int Level = 0;
  std::array<double, 3> Steps = { 1, 1, 1 };
  TiffFormat Format;
  VertexBox Box;
  Index3 Chunk = { 1, 1, 1 };
  std::uint64_t ScratchBytes = 0;
  std::size_t OpenNumber = 0;
  std::unique_ptr<TiffFile> Opened;
};

} // namespace isosurface

#endif
