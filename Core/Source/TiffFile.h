// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffFile_h
#define isosurface_TiffFile_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Volume/ValueType.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// What a page of a TIFF file holds. Two pages of one stack have equal formats.
struct TiffFormat
{
  std::int64_t Width = 0;
  std::int64_t Height = 0;
  ValueType Type = ValueType::UInt8;

  bool operator==(const TiffFormat& other) const
  {
    return this->Width == other.Width && this->Height == other.Height && this->Type == other.Type;
  }
};

/// Where a page of a TIFF file stands.
struct TiffPage
{
  std::uint64_t Directory = 0; ///< offset of its directory
  std::uint64_t Shift = 0;     ///< its samples stand so many bytes behind those the directory names
};

/// A rectangle of a page, [Low, High) on each axis.
struct TiffRectangle
{
  std::int64_t LowX = 0;
  std::int64_t HighX = 0;
  std::int64_t LowY = 0;
  std::int64_t HighY = 0;
};

/**
 * A TIFF or BigTIFF file of one or several pages of one sample a pixel: integers of 8, 16, 32 or 64
 * bits, floats of 32 or 64; in strips or tiles, in either byte order, compressed by whatever
 * libtiff knows. Samples are taken as they are stored, the first row of the file first, whatever
 * the photometric interpretation. What ImageJ writes beyond 4 GiB is known as well: one directory,
 * and the samples of all pages behind each other.
 *
 * One thread at a time may use a file. Errors name file and page.
 *
 * Sources: Adobe, "TIFF Revision 6.0", 1992; libtiff's documentation of BigTIFF; ImageJ's
 * ij.io.TiffEncoder for the text in ImageDescription.
 */
class TiffFile
{
public:
  static Result<std::unique_ptr<TiffFile>> Open(FileSystem& files, const std::string& path);
  TiffFile(const TiffFile&) = delete;
  TiffFile& operator=(const TiffFile&) = delete;
  ~TiffFile();

  /// Reads the directories of all pages: their places, by order in the file. Corrupt if pages have
  /// different formats, or numbers (tag PageNumber) that go down.
  Result<std::vector<TiffPage>> FindPages();

  /// Of all pages, once they are found.
  const TiffFormat& GetFormat() const { return this->Format; }
  /// Instead of finding the pages once more: what they were found to have.
  void SetFormat(const TiffFormat& format) { this->Format = format; }
  /// The memory that reading takes beside the samples' own, at most, once the pages are found.
  std::uint64_t GetScratchBytes() const { return this->ScratchBytes; }

  /// Reads a rectangle, row by row, without gaps, in the machine's byte order.
  Status Read(const TiffPage& page, const TiffRectangle& rectangle, std::uint8_t* to);

private:
  struct Handle;
  explicit TiffFile(std::unique_ptr<Handle> handle);

  /// What the current directory says, if it can be read.
  Result<TiffFormat> ReadFormat();
  /// The pages of a file whose one directory stands for several, by ImageJ's description.
  Result<std::vector<TiffPage>> ExpandImageJ(const TiffPage& first) const;
  Status SelectPage(const TiffPage& page);
  Status ReadRows(const TiffPage& page, const TiffRectangle& rectangle, std::uint8_t* to);
  Status ReadStrips(const TiffRectangle& rectangle, std::uint8_t* to);
  Status ReadTiles(const TiffRectangle& rectangle, std::uint8_t* to);
  /// Whether the code of a strip or tile is within the file.
  bool HasCodeOf(std::uint32_t strile) const;
  /// An error that names file and page; libtiff's own reason, if it gave one, or else `reason`.
  Status MakeError(StatusCode code, const std::string& reason) const;

  std::unique_ptr<Handle> Tiff;
  TiffFormat Format;
  std::uint64_t ScratchBytes = 0;
  std::vector<std::uint8_t> Scratch; ///< a strip or tile
};

} // namespace isosurface

#endif
