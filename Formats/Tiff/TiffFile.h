// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffFile_h
#define isosurface_TiffFile_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ValueType.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

struct TiffHandle;

/// The format of a page of a TIFF file. All pages of a stack have the same format.
struct TiffFormat
{
  std::int64_t Width = 0;
  std::int64_t Height = 0;
  ValueType Type = ValueType::UInt8;
  std::int64_t Components = 1; ///< samples of a pixel that follow each other
  std::int64_t Planes = 1;     ///< samples of a pixel that are stored one plane after the other

  bool operator==(const TiffFormat& other) const
  {
    return this->Width == other.Width && this->Height == other.Height && this->Type == other.Type &&
      this->Components == other.Components && this->Planes == other.Planes;
  }
  std::size_t GetPixelBytes() const
  {
    return static_cast<std::size_t>(this->Components) * GetValueSize(this->Type);
  }
};

/// The place of a page in a TIFF file.
struct TiffPage
{
  std::uint64_t Directory = 0; ///< offset of its directory
  std::uint64_t Shift = 0;     ///< from the samples that the directory names to those of the page
  int Format = -1;             ///< number of its format; -1: it cannot be read
  std::uint16_t Plane = 0;
  bool IsOfAnother = false;     ///< whether it is a smaller image or a mask of another page
  std::uint32_t FirstLevel = 0; ///< of its smaller images, among those of all pages
};

/// What the directories of a TIFF file tell.
struct TiffContents
{
  std::vector<TiffPage> Pages; ///< in the order of the file
  std::vector<TiffFormat> Formats;
  std::string Description; ///< of the first page (tag ImageDescription)
  /// Pages with tifffile's JSON in their descriptions.
  std::vector<std::pair<std::int64_t, std::string>> Shapes;
  double XResolution = 0; ///< pixels of a unit; 0: not known
  double YResolution = 0;
  int ResolutionUnit = 1; ///< 2: inch, 3: centimetre
  std::string Notes;      ///< what other tags say of the samples that is not obeyed
  std::string
    Program; ///< that describes the pages in its own way, which is not read; perhaps empty
  Status PageNumbers = Status::Ok(); ///< an error if they descend
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
 * A TIFF or BigTIFF file of one or more pages, whose samples are no colours: integers of 8, 16, 32 or 64
 * bits, or floats of 32 or 64 bits; in strips or tiles; in either byte order; uncompressed or with
 * LZW, deflate, PackBits, zstd, LZMA or JPEG; up to 2^20 pages. Samples are read as they are
 * stored, the first row first, for any photometric interpretation. Also reads the files that ImageJ
 * writes beyond 4 GiB: one directory, followed by the samples of all pages. A page may have smaller
 * images of itself, as OME-TIFF has them (tag SubIFDs): these are the levels of a pyramid. Strips and
 * tiles that do not exist, as in sparse files of GDAL, have the samples of its tag GDAL_NODATA, or 0.
 *
 * One thread at a time may use a file. Errors name the file and the page.
 *
 * Sources: Adobe, "TIFF Revision 6.0", 1992, and "Adobe PageMaker 6.0 TIFF Technical Notes", 1995,
 * for SubIFDs; libtiff's documentation of BigTIFF; ImageJ's ij.io.TiffEncoder for the text in
 * ImageDescription; "OME-TIFF specification", section "Sub-resolutions".
 */
class TiffFile
{
public:
  static Result<std::unique_ptr<TiffFile>> Open(FileSystem& files, const std::string& path);
  TiffFile(const TiffFile&) = delete;
  TiffFile& operator=(const TiffFile&) = delete;
  ~TiffFile();

  /// Reads the directories of all pages. A page that cannot be read is no error yet. ImageJ and
  /// tifffile may have a single directory for several pages, which follow each other.
  Result<TiffContents> FindPages();

  /// The number of smaller images that each page has, after FindPages(); 0 if pages differ in it.
  std::size_t GetNumberOfLevels() const { return this->Levels; }
  /// The `level`-th smaller image, from 1, of a page of FindPages().
  TiffPage GetPageOfLevel(const TiffPage& page, std::size_t level) const
  {
    TiffPage smaller = page;
    smaller.Directory = this->SmallerPages[page.FirstLevel + level - 1];
    return smaller;
  }
  /// An error that names the file and a page.
  Status MakeErrorOf(const TiffPage& page, StatusCode code, const std::string& reason);
  /// Takes format, unit and scratch from a page: the first one of a level, or of the file. Errors:
  /// Corrupt, Unsupported.
  Status TakeFormat(const TiffPage& first);

  /// The format of all pages, after TakeFormat() or SetFormat().
  const TiffFormat& GetFormat() const { return this->Format; }
  /// Sets the format that FindPages() found before, when a file is opened again.
  void SetFormat(const TiffFormat& format) { this->Format = format; }
  /// The width and height of the part of a page that is decoded at once, after TakeFormat(): a strip
  /// or a tile, or a row if nothing is decoded.
  const std::array<std::int64_t, 2>& GetUnit() const { return this->Unit; }
  /// The maximum memory for reading, besides the samples, after FindPages() and TakeFormat().
  std::uint64_t GetScratchBytes() const { return this->ScratchBytes; }

  /// Reads a rectangle of a plane, row by row, without gaps, in the byte order of the machine.
  Status Read(const TiffPage& page, const TiffRectangle& rectangle, std::uint8_t* to);

private:
  /// Where the bytes of a strip or tile ("strile") are in the file.
  struct Strile
  {
    std::uint64_t Offset = 0;
    std::uint64_t Size = 0;

    /// GDAL writes neither a strip nor a tile of a sparse file that has no samples.
    bool IsAbsent() const { return this->Offset == 0 && this->Size == 0; }
  };

  explicit TiffFile(std::unique_ptr<TiffHandle> handle);

  /// The format of the current directory. Errors: Corrupt, Unsupported.
  Result<TiffFormat> ReadFormat();
  /// The unit of the current directory.
  std::array<std::int64_t, 2> FindUnit() const;
  /// What decoding a strip or tile of the current directory takes. Errors: Corrupt.
  Result<std::uint64_t> FindScratchBytes(const TiffFormat& format) const;
  /// Whether the current directory is of a smaller image or a mask of another page.
  bool IsOfAnotherPage() const;
  /// Adds the smaller images of the current directory, which is that of a page.
  void AddLevels(TiffPage& page, bool isFirst);
  /// The text of the current directory (tag ImageDescription), perhaps empty.
  std::string FindDescription() const;
  /// What the tags of the current directory, the first one, tell.
  void TakeTags(TiffContents& contents) const;
  /// The pages that the single directory of a file stands for.
  Status Expand(TiffContents& contents);
  Status SelectPage(const TiffPage& page);
  Status ReadRows(const TiffPage& page, const TiffRectangle& rectangle, std::uint8_t* to);
  Status ReadStrips(const TiffPage& page, const TiffRectangle& rectangle, std::uint8_t* to);
  Status ReadTiles(const TiffPage& page, const TiffRectangle& rectangle, std::uint8_t* to);
  /// A strip or tile of the current directory. Errors: Corrupt.
  Result<Strile> FindStrile(std::uint32_t number) const;
  /// The number of GDAL's tag for missing samples, as text; perhaps empty.
  std::string FindNoData() const;
  /// The bytes of a sample that the file does not have: GDAL's number if it gives one that the type
  /// has, or else 0.
  std::array<std::uint8_t, 8> FindFill() const;
  /// Whether the bytes of a strip or tile are within the file.
  bool HasCodeOf(const Strile& strile) const;
  /// An error that names the file and the page. The reason is that of libtiff if there is one,
  /// otherwise `reason`.
  Status MakeError(StatusCode code, const std::string& reason) const;

  std::unique_ptr<TiffHandle> Tiff;
  bool IsOfImageJ = false; ///< whose palettes are for showing grey samples
  TiffFormat Format;
  std::array<std::int64_t, 2> Unit = { 1, 1 };
  std::uint64_t ScratchBytes = 0;
  std::size_t Levels = 0;
  std::vector<std::uint64_t> SmallerPages; ///< directories: those of a page follow each other
  std::vector<std::uint8_t> Scratch;       ///< a strip or tile
};

} // namespace isosurface

#endif
