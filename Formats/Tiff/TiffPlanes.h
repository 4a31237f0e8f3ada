// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffPlanes_h
#define isosurface_TiffPlanes_h

#include "Formats/Source/StoredArray.h"
#include "Formats/Tiff/TiffFile.h"
#include "Formats/Tiff/TiffImage.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/VolumeOpener.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

/// The files of a volume, whose directories are read when they are needed. Not more than 256 stay open.
class TiffFiles
{
public:
  struct ReadFile
  {
    std::unique_ptr<TiffFile> File;
    TiffContents Contents;
  };

  /// `own`: the path of the file whose description tells what the others are.
  TiffFiles(FileSystem& files, std::string own)
    : Files(files)
    , Own(std::move(own))
  {
  }

  FileSystem& GetFileSystem() const { return this->Files; }
  const std::string& GetOwn() const { return this->Own; }
  /// The path of a file that a description names; the own one, if the name is empty.
  std::string FindPath(const std::string& name) const;
  /// The file stays open until the next one is opened, the own one always.
  Result<ReadFile*> Open(const std::string& path);
  /// An error that names the own file, as others of opening.
  Status MakeError(StatusCode code, const std::string& reason) const
  {
    return Status(code, this->Own + ": cannot be read: " + reason);
  }

  /// Leaves out pages that are smaller images or masks of others, like the thumbnails of microscopes.
  /// All others must have the format of the first one, and numbers that do not descend.
  static Status CheckStack(ReadFile& read);

private:
  FileSystem& Files;
  std::string Own;
  std::map<std::string, ReadFile> Read;
};

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

/// The pages of a time step of an image, or of a level of their pyramid.
class TiffPlanes
{
public:
  /// `files` must outlive the planes.
  TiffPlanes(TiffFiles& files, const VolumeChoice& choice)
    : Files(files)
    , Choice(choice)
  {
  }

  /// Finds the pages that an image says. Errors: Corrupt, if a slice is missing; Unsupported.
  Status TakeImage(TiffImage& image);
  /// Takes the pages of several files, one after the other, as slices.
  Status TakeStack(const std::vector<std::string>& paths, TiffImage& image);
  /// Goes to the finest level of at most the chosen number of vertices, or the coarsest.
  void ChooseLevel();

  /// The slices of each channel that is there.
  const std::map<std::int64_t, std::vector<TiffSlice>>& GetChannels() const
  {
    return this->Channels;
  }
  /// The paths that slices have the numbers of.
  const std::vector<std::string>& GetPaths() const { return this->Paths; }
  const TiffFormat& GetFormat() const { return *this->Format; }
  /// The level of the pyramid; 0: the pages themselves.
  std::size_t GetLevel() const { return this->Level; }
  /// How many samples of the pages are between two of the level, on each axis.
  const std::array<double, 3>& GetSteps() const { return this->Steps; }

private:
  using Slices = std::vector<TiffSlice>;

  Status CheckImage(TiffImage& image);
  std::size_t NumberFile(const std::string& path);
  /// A page as a slice; its smaller images are kept if a level is chosen.
  Result<TiffSlice> MakeSlice(
    TiffFiles::ReadFile& read, const std::string& path, const TiffPage& page);
  TiffSlice FindSmaller(TiffSlice slice, std::size_t level) const;
  /// The format of a level, from 1; nothing if its first page cannot be one of a smaller image.
  std::optional<TiffFormat> FindFormatOfLevel(std::size_t level) const;

  TiffFiles& Files;
  const VolumeChoice& Choice;
  std::map<std::int64_t, Slices> Channels;
  std::vector<std::string> Paths;
  std::map<std::string, std::size_t> Numbers; ///< of Paths
  std::optional<TiffFormat> Format;
  std::size_t Levels = 0; ///< that all pages have
  /// The directories of the smaller images of pages, by file and directory, if a level is chosen.
  std::map<std::pair<std::size_t, std::uint64_t>, std::vector<std::uint64_t>> Smaller;
  std::size_t Level = 0;
  std::array<double, 3> Steps{ 1, 1, 1 };
};

} // namespace isosurface

#endif
