// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffFile.h"

#include "Formats/Source/TextFields.h"
#include "Formats/Tiff/TiffDescription.h"
#include "Formats/Tiff/TiffHandle.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

namespace isosurface
{
namespace
{

/// The maximum number of rows and columns.
constexpr std::uint64_t MaximumSize = std::uint64_t{ 1 } << 31;
/// The maximum number of pages of a file: each takes memory, and ImageJ's one byte of the file.
constexpr std::size_t MaximumPages = std::size_t{ 1 } << 20;
/// The maximum number of smaller images of a page: each is half as wide, or so.
constexpr std::size_t MaximumLevels = 31;
/// The maximum size of a page. Four times as much is a number, too.
constexpr std::uint64_t MaximumPageBytes = std::uint64_t{ 1 } << 60;
/// The tag with which GDAL says what samples are that do not exist: a number as text.
constexpr std::uint32_t NoDataTag = 42113;

/// A way to compress that libtiff may know.
struct Compression
{
  std::uint16_t Code;
  const char* Name;
  bool IsRead;
};
// Those that are not read are of other samples than ours (WebP of colours, ThunderScan of 4 bits), or
// let the file choose other samples than the directory says.
constexpr Compression Compressions[] = { { COMPRESSION_NONE, "none", true },
  { COMPRESSION_LZW, "LZW", true }, { COMPRESSION_ADOBE_DEFLATE, "deflate", true },
  { COMPRESSION_DEFLATE, "deflate", true }, { COMPRESSION_PACKBITS, "PackBits", true },
  { COMPRESSION_ZSTD, "zstd", true }, { COMPRESSION_LZMA, "LZMA", true },
  { COMPRESSION_JPEG, "JPEG", true }, { COMPRESSION_OJPEG, "old JPEG", false },
  { COMPRESSION_THUNDERSCAN, "ThunderScan", false }, { COMPRESSION_PIXARLOG, "PixarLog", false },
  { COMPRESSION_JBIG, "JBIG", false }, { COMPRESSION_SGILOG, "SGILog", false },
  { COMPRESSION_SGILOG24, "SGILog", false }, { COMPRESSION_LERC, "LERC", false },
  { COMPRESSION_WEBP, "WebP", false } };

/// Why a compression is not read; nothing if it is.
std::optional<std::string> FindFaultOfCompression(std::uint16_t code)
{
  const auto* const found = std::find_if(std::begin(Compressions), std::end(Compressions),
    [code](const Compression& compression) { return compression.Code == code; });
  const bool isKnown = found != std::end(Compressions);
  if (isKnown && found->IsRead && ::TIFFIsCODECConfigured(code) != 0)
  {
    return std::nullopt;
  }
  return "its compression (" + std::to_string(code) +
    (isKnown ? std::string(", ") + found->Name : std::string()) + ") is not supported" +
    (isKnown && found->IsRead ? " by this libtiff" : "");
}

std::optional<ValueType> FindSampleType(std::uint16_t format, std::uint16_t bits)
{
  const bool isSigned = format == SAMPLEFORMAT_INT;
  if (format == SAMPLEFORMAT_IEEEFP)
  {
    return bits == 32 ? std::optional(ValueType::Float32)
      : bits == 64    ? std::optional(ValueType::Float64)
                      : std::nullopt;
  }
  if (!isSigned && format != SAMPLEFORMAT_UINT && format != SAMPLEFORMAT_VOID)
  {
    return std::nullopt;
  }
  return bits % 8 == 0 ? FindIntegerType(bits / 8, isSigned) : std::nullopt;
}

/// GDAL's text of a number as a sample; nothing if the type does not have it.
template <typename T>
std::optional<T> ParseSample(const std::string& text)
{
  if constexpr (std::is_integral_v<T>)
  {
    T whole = 0;
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, whole);
    return read.ec == std::errc() && read.ptr == end ? std::optional(whole) : std::nullopt;
  }
  else
  {
    if (LowerText(text) == "nan")
    {
      return std::numeric_limits<T>::quiet_NaN();
    }
    // Rounded to fewer digits, the largest float is a little beyond itself.
    const double most = std::numeric_limits<T>::max();
    const std::optional<double> number = ParseDouble(text);
    return number && std::abs(*number) / (1 + 1e-7) <= most
      ? std::optional(static_cast<T>(std::clamp(*number, -most, most)))
      : std::nullopt;
  }
}

/// Sets all samples to one.
void FillSamples(std::uint8_t* samples, std::size_t bytes, const std::array<std::uint8_t, 8>& fill,
  std::size_t valueSize)
{
  for (std::size_t at = 0; at < bytes; at += valueSize)
  {
    std::memcpy(samples + at, fill.data(), valueSize);
  }
}

/// Puts samples of the file into the byte order of the machine.
void SwapSamples(std::uint8_t* samples, std::size_t bytes, std::size_t valueSize)
{
  const auto count = static_cast<tmsize_t>(bytes / valueSize);
  if (valueSize == 2)
  {
    ::TIFFSwabArrayOfShort(reinterpret_cast<std::uint16_t*>(samples), count);
  }
  else if (valueSize == 4)
  {
    ::TIFFSwabArrayOfLong(reinterpret_cast<std::uint32_t*>(samples), count);
  }
  else if (valueSize == 8)
  {
    ::TIFFSwabArrayOfLong8(reinterpret_cast<std::uint64_t*>(samples), count);
  }
}

} // namespace

TiffFile::TiffFile(std::unique_ptr<TiffHandle> handle)
  : Tiff(std::move(handle))
{
}

TiffFile::~TiffFile() = default;

Result<std::unique_ptr<TiffFile>> TiffFile::Open(FileSystem& files, const std::string& path)
{
  auto file = files.OpenForReading(path);
  ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
  auto handle = TiffHandle::Open(std::move(*file));
  ISOSURFACE_RETURN_IF_ERROR(handle.GetStatus());
  return std::unique_ptr<TiffFile>(new TiffFile(std::move(*handle)));
}

Status TiffFile::MakeError(StatusCode code, const std::string& reason) const
{
  if (!this->Tiff->Failure.IsOk())
  {
    return this->Tiff->Failure;
  }
  return Status(code,
    this->Tiff->File->GetPath() + ": page " +
      std::to_string(std::uint64_t{ ::TIFFCurrentDirectory(this->Tiff->Tiff) } + 1) + ": " +
      (this->Tiff->Reason.empty() || code != StatusCode::Corrupt ? reason : this->Tiff->Reason));
}

Result<TiffFormat> TiffFile::ReadFormat()
{
  const TiffHandle& tiff = *this->Tiff;
  const auto width = tiff.Get<std::uint32_t>(TIFFTAG_IMAGEWIDTH, 0);
  const auto height = tiff.Get<std::uint32_t>(TIFFTAG_IMAGELENGTH, 0);
  if (width == 0 || height == 0 || width > MaximumSize || height > MaximumSize)
  {
    return this->MakeError(StatusCode::Corrupt, "its width or height is impossible");
  }
  if (tiff.Get<std::uint16_t>(TIFFTAG_SAMPLESPERPIXEL, 1) != 1)
  {
    return this->MakeError(StatusCode::Unsupported,
      "it has " + std::to_string(tiff.Get<std::uint16_t>(TIFFTAG_SAMPLESPERPIXEL, 1)) +
        " samples a pixel; only one is supported");
  }
  if (tiff.Get<std::uint32_t>(TIFFTAG_IMAGEDEPTH, 1) > 1 ||
    tiff.Get<std::uint32_t>(TIFFTAG_TILEDEPTH, 1) > 1)
  {
    return this->MakeError(StatusCode::Unsupported, "pages of several slices are not supported");
  }
  const auto format = tiff.Get<std::uint16_t>(TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  const auto bits = tiff.Get<std::uint16_t>(TIFFTAG_BITSPERSAMPLE, 1);
  const auto type = FindSampleType(format, bits);
  if (!type)
  {
    return this->MakeError(StatusCode::Unsupported,
      "samples of " + std::to_string(bits) + " bits (SampleFormat " + std::to_string(format) +
        ") are not supported");
  }
  const auto compression = tiff.Get<std::uint16_t>(TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  if (const auto fault = FindFaultOfCompression(compression))
  {
    return this->MakeError(StatusCode::Unsupported, *fault);
  }
  if (std::uint64_t{ width } * height > MaximumPageBytes / GetValueSize(*type))
  {
    return this->MakeError(StatusCode::Corrupt, "its width or height is impossible");
  }
  return TiffFormat{ static_cast<std::int64_t>(width), static_cast<std::int64_t>(height), *type };
}

std::array<std::int64_t, 2> TiffFile::FindUnit() const
{
  const TiffHandle& tiff = *this->Tiff;
  const bool isTiled = ::TIFFIsTiled(tiff.Tiff) != 0;
  const bool isPlain =
    tiff.Get<std::uint16_t>(TIFFTAG_COMPRESSION, COMPRESSION_NONE) == COMPRESSION_NONE;
  const std::int64_t width =
    isTiled ? tiff.Get<std::uint32_t>(TIFFTAG_TILEWIDTH, 1) : this->Format.Width;
  const std::int64_t height = isTiled ? tiff.Get<std::uint32_t>(TIFFTAG_TILELENGTH, 1)
    : isPlain                         ? 1
                                      : tiff.Get<std::uint32_t>(TIFFTAG_ROWSPERSTRIP, 1);
  return { std::clamp<std::int64_t>(width, 1, this->Format.Width),
    std::clamp<std::int64_t>(height, 1, this->Format.Height) };
}

Result<std::uint64_t> TiffFile::FindScratchBytes(const TiffFormat& format) const
{
  ::TIFF* tiff = this->Tiff->Tiff;
  const tmsize_t scratch = ::TIFFIsTiled(tiff) != 0 ? ::TIFFTileSize(tiff) : ::TIFFStripSize(tiff);
  const std::uint64_t pageBytes = static_cast<std::uint64_t>(format.Width) *
    static_cast<std::uint64_t>(format.Height) * GetValueSize(format.Type);
  if (scratch <= 0 ||
    static_cast<std::uint64_t>(scratch) > 4 * pageBytes + TiffHandle::MaximumTableSize)
  {
    return this->MakeError(StatusCode::Corrupt, "the size of its strips or tiles is impossible");
  }
  // Uncompressed and compressed.
  return 2 * static_cast<std::uint64_t>(scratch);
}

bool TiffFile::IsOfAnotherPage() const
{
  const auto type = this->Tiff->Get<std::uint32_t>(TIFFTAG_SUBFILETYPE, 0);
  return (type & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
}

void TiffFile::AddLevels(bool isFirst)
{
  std::uint16_t count = 0;
  const std::uint64_t* directories = nullptr;
  if (::TIFFGetField(this->Tiff->Tiff, TIFFTAG_SUBIFD, &count, &directories) != 1)
  {
    count = 0;
  }
  if (isFirst)
  {
    this->Levels = count <= MaximumLevels ? count : 0;
  }
  if (count != this->Levels)
  {
    this->Levels = 0;
    this->SmallerPages.clear();
  }
  this->SmallerPages.insert(this->SmallerPages.end(), directories, directories + this->Levels);
}

Status TiffFile::TakeFormat(const TiffPage& first)
{
  if (::TIFFSetSubDirectory(this->Tiff->Tiff, first.Directory) != 1)
  {
    return this->MakeError(StatusCode::Corrupt, "its directory cannot be read");
  }
  const auto format = this->ReadFormat();
  ISOSURFACE_RETURN_IF_ERROR(format.GetStatus());
  const auto scratch = this->FindScratchBytes(*format);
  ISOSURFACE_RETURN_IF_ERROR(scratch.GetStatus());
  this->Format = *format;
  this->Unit = this->FindUnit();
  this->ScratchBytes = *scratch;
  return Status::Ok();
}

Result<std::vector<TiffPage>> TiffFile::FindPages()
{
  ::TIFF* tiff = this->Tiff->Tiff;
  std::vector<TiffPage> pages;
  std::string text; // of the first page
  int lastNumber = -1;
  do
  {
    auto format = this->ReadFormat();
    if (!pages.empty() && this->IsOfAnotherPage() && !(format.IsOk() && *format == this->Format))
    {
      continue;
    }
    ISOSURFACE_RETURN_IF_ERROR(format.GetStatus());
    if (!pages.empty() && !(*format == this->Format))
    {
      return this->MakeError(
        StatusCode::Unsupported, "its size or type differs from that of the pages before");
    }
    this->Format = *format;
    this->Unit = pages.empty() ? this->FindUnit() : this->Unit;
    if (pages.size() == MaximumPages)
    {
      return this->MakeError(StatusCode::Unsupported,
        "at most " + std::to_string(MaximumPages) + " pages are supported");
    }
    std::uint16_t number = 0;
    std::uint16_t count = 0;
    if (::TIFFGetField(tiff, TIFFTAG_PAGENUMBER, &number, &count) == 1)
    {
      if (number < lastNumber)
      {
        return this->MakeError(StatusCode::Unsupported,
          "its page number is " + std::to_string(number) + ", that of the page before is " +
            std::to_string(lastNumber));
      }
      lastNumber = number;
    }
    const auto scratch = this->FindScratchBytes(*format);
    ISOSURFACE_RETURN_IF_ERROR(scratch.GetStatus());
    this->ScratchBytes = std::max(this->ScratchBytes, *scratch);
    this->AddLevels(pages.empty());
    if (pages.empty())
    {
      text = this->FindDescription();
    }
    pages.push_back({ ::TIFFCurrentDirOffset(tiff), 0 });
  } while (::TIFFReadDirectory(tiff) == 1);
  // The last directory ends the loop without an error; so does one that cannot be read, with one.
  if (!this->Tiff->Failure.IsOk() || !this->Tiff->Reason.empty())
  {
    return this->MakeError(StatusCode::Corrupt, "the directory of the next page cannot be read");
  }
  const std::string fault =
    TiffDescription::Parse(text).FindFault(static_cast<std::int64_t>(pages.size()));
  if (pages.size() > 1 && !fault.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(this->SelectPage(pages[0]));
    return this->MakeError(StatusCode::Unsupported, fault);
  }
  auto expanded = pages.size() == 1 ? this->ExpandImageJ(pages[0]) : pages;
  this->Levels = expanded.IsOk() && expanded->size() == pages.size() ? this->Levels : 0;
  return expanded;
}

std::string TiffFile::FindDescription() const
{
  const char* found = nullptr;
  const bool hasText =
    ::TIFFGetField(this->Tiff->Tiff, TIFFTAG_IMAGEDESCRIPTION, &found) == 1 && found;
  return hasText ? found : "";
}

Result<std::vector<TiffPage>> TiffFile::ExpandImageJ(const TiffPage& first) const
{
  const TiffDescription description = TiffDescription::Parse(this->FindDescription());
  const std::int64_t images = description.Images;
  if (!description.IsOfImageJ || images <= 1)
  {
    return std::vector<TiffPage>{ first };
  }
  const std::uint64_t bytes = static_cast<std::uint64_t>(this->Format.Width) *
    static_cast<std::uint64_t>(this->Format.Height) * GetValueSize(this->Format.Type);
  if (const std::string fault = description.FindFault(images); !fault.empty())
  {
    return this->MakeError(StatusCode::Unsupported, fault);
  }
  const std::uint64_t begin = ::TIFFGetStrileOffset(this->Tiff->Tiff, 0);
  const std::uint64_t size = this->Tiff->File->GetSize();
  if (this->Tiff->Get<std::uint16_t>(TIFFTAG_COMPRESSION, COMPRESSION_NONE) != COMPRESSION_NONE ||
    ::TIFFNumberOfStrips(this->Tiff->Tiff) != 1 || begin == 0 || begin > size ||
    static_cast<std::uint64_t>(images) > (size - begin) / bytes)
  {
    return this->MakeError(StatusCode::Corrupt,
      "truncated: ImageJ's description speaks of " + std::to_string(images) +
        " images, which are not there");
  }
  if (static_cast<std::uint64_t>(images) > MaximumPages)
  {
    return this->MakeError(StatusCode::Unsupported,
      "ImageJ wrote " + std::to_string(images) + " images; at most " +
        std::to_string(MaximumPages) + " pages are supported");
  }
  std::vector<TiffPage> pages;
  for (std::uint64_t image = 0; image < static_cast<std::uint64_t>(images); ++image)
  {
    pages.push_back({ first.Directory, image * bytes });
  }
  return pages;
}

Status TiffFile::SelectPage(const TiffPage& page)
{
  ::TIFF* tiff = this->Tiff->Tiff;
  if (::TIFFCurrentDirOffset(tiff) == page.Directory)
  {
    return Status::Ok();
  }
  if (::TIFFSetSubDirectory(tiff, page.Directory) != 1)
  {
    return this->MakeError(StatusCode::Corrupt, "its directory cannot be read");
  }
  const auto format = this->ReadFormat();
  if (!format.IsOk() || !(*format == this->Format))
  {
    return format.IsOk() ? this->MakeError(StatusCode::Corrupt, "its directory has changed")
                         : format.GetStatus();
  }
  return Status::Ok();
}

Status TiffFile::Read(const TiffPage& page, const TiffRectangle& rectangle, std::uint8_t* to)
{
  ISOSURFACE_RETURN_IF_ERROR(this->SelectPage(page));
  ::TIFF* tiff = this->Tiff->Tiff;
  if (::TIFFIsTiled(tiff) != 0)
  {
    return this->ReadTiles(rectangle, to);
  }
  const auto compression = this->Tiff->Get<std::uint16_t>(TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  const auto order = this->Tiff->Get<std::uint16_t>(TIFFTAG_FILLORDER, FILLORDER_MSB2LSB);
  return compression == COMPRESSION_NONE && order == FILLORDER_MSB2LSB
    ? this->ReadRows(page, rectangle, to)
    : this->ReadStrips(rectangle, to);
}

/// Rows that stand in the file as they are.
Status TiffFile::ReadRows(const TiffPage& page, const TiffRectangle& rectangle, std::uint8_t* to)
{
  ::TIFF* tiff = this->Tiff->Tiff;
  const std::uint64_t valueSize = GetValueSize(this->Format.Type);
  const std::uint64_t rowBytes = static_cast<std::uint64_t>(this->Format.Width) * valueSize;
  const bool isWhole = rectangle.LowX == 0 && rectangle.HighX == this->Format.Width;
  const auto bytes = static_cast<std::size_t>(rectangle.HighX - rectangle.LowX) *
    static_cast<std::size_t>(valueSize);
  const std::int64_t rowsPerStrip = std::max<std::int64_t>(1,
    std::min<std::int64_t>(
      this->Tiff->Get<std::uint32_t>(TIFFTAG_ROWSPERSTRIP, 1), this->Format.Height));
  for (std::int64_t row = rectangle.LowY; row < rectangle.HighY;)
  {
    const std::int64_t number = row / rowsPerStrip;
    const std::int64_t end = std::min(rectangle.HighY, (number + 1) * rowsPerStrip);
    const std::int64_t rows = isWhole ? end - row : 1;
    const std::size_t size = bytes * static_cast<std::size_t>(rows);
    const auto strip = this->FindStrile(static_cast<std::uint32_t>(number));
    ISOSURFACE_RETURN_IF_ERROR(strip.GetStatus());
    const auto skipped = static_cast<std::uint64_t>(row - number * rowsPerStrip);
    if (strip->IsAbsent())
    {
      FillSamples(to, size, this->FindFill(), valueSize);
    }
    else if (strip->Offset == 0 ||
      strip->Size / rowBytes < skipped + static_cast<std::uint64_t>(rows))
    {
      return this->MakeError(StatusCode::Corrupt,
        "the strip of row " + std::to_string(number * rowsPerStrip) + " is truncated: it has " +
          std::to_string(strip->Size) + " bytes");
    }
    else
    {
      const std::uint64_t offset = strip->Offset + page.Shift + skipped * rowBytes +
        static_cast<std::uint64_t>(rectangle.LowX) * valueSize;
      ISOSURFACE_RETURN_IF_ERROR(this->Tiff->File->Read(offset, size, to));
      if (::TIFFIsByteSwapped(tiff) != 0)
      {
        SwapSamples(to, size, valueSize);
      }
    }
    to += size;
    row += rows;
  }
  return Status::Ok();
}

Result<TiffFile::Strile> TiffFile::FindStrile(std::uint32_t number) const
{
  // The functions without "WithErr" give 0 as well when they cannot read.
  int hasNoOffset = 0;
  int hasNoSize = 0;
  Strile strile;
  strile.Offset = ::TIFFGetStrileOffsetWithErr(this->Tiff->Tiff, number, &hasNoOffset);
  strile.Size = ::TIFFGetStrileByteCountWithErr(this->Tiff->Tiff, number, &hasNoSize);
  if (hasNoOffset != 0 || hasNoSize != 0)
  {
    return this->MakeError(
      StatusCode::Corrupt, "truncated: the places of its strips or tiles are not there");
  }
  return strile;
}

std::array<std::uint8_t, 8> TiffFile::FindFill() const
{
  ::TIFF* tiff = this->Tiff->Tiff;
  std::string text;
  const ::TIFFField* field = ::TIFFFindField(tiff, NoDataTag, TIFF_ANY);
  if (field && ::TIFFFieldDataType(field) == TIFF_ASCII)
  {
    std::uint32_t count = 0;
    const char* found = nullptr;
    // libtiff does not know the tag and counts its letters, unless GDAL is in the process, too.
    const bool isCounted = ::TIFFFieldPassCount(field) != 0;
    const int isFound = isCounted ? ::TIFFGetField(tiff, NoDataTag, &count, &found)
                                  : ::TIFFGetField(tiff, NoDataTag, &found);
    if (isFound == 1 && found)
    {
      text = isCounted ? std::string(found, count) : std::string(found);
      text = TrimText(text.substr(0, text.find('\0')));
    }
  }
  std::array<std::uint8_t, 8> fill = {};
  DispatchValueType(this->Format.Type,
    [&](auto type)
    {
      const auto sample = ParseSample<decltype(type)>(text).value_or(type);
      std::memcpy(fill.data(), &sample, sizeof(sample));
    });
  return fill;
}

// libtiff 4.5 writes outside of its memory when code cannot be read that the directory promises.
bool TiffFile::HasCodeOf(const Strile& strile) const
{
  const std::uint64_t size = this->Tiff->File->GetSize();
  return strile.Offset <= size && strile.Size <= size - strile.Offset;
}

Status TiffFile::ReadStrips(const TiffRectangle& rectangle, std::uint8_t* to)
{
  ::TIFF* tiff = this->Tiff->Tiff;
  const std::size_t valueSize = GetValueSize(this->Format.Type);
  const std::size_t rowBytes = static_cast<std::size_t>(this->Format.Width) * valueSize;
  const auto bytes = static_cast<std::size_t>(rectangle.HighX - rectangle.LowX) * valueSize;
  const std::int64_t rowsPerStrip = std::max<std::int64_t>(1,
    std::min<std::int64_t>(
      this->Tiff->Get<std::uint32_t>(TIFFTAG_ROWSPERSTRIP, 1), this->Format.Height));
  for (std::int64_t row = rectangle.LowY; row < rectangle.HighY;)
  {
    const std::int64_t first = row / rowsPerStrip * rowsPerStrip;
    const std::int64_t end = std::min(first + rowsPerStrip, this->Format.Height);
    const std::size_t stripBytes = static_cast<std::size_t>(end - first) * rowBytes;
    const bool isWhole = row == first && end <= rectangle.HighY && rowBytes == bytes;
    const auto number = static_cast<std::uint32_t>(first / rowsPerStrip);
    const std::int64_t last = std::min(end, rectangle.HighY);
    const auto found = this->FindStrile(number);
    ISOSURFACE_RETURN_IF_ERROR(found.GetStatus());
    if (found->IsAbsent())
    {
      const std::size_t size = static_cast<std::size_t>(last - row) * bytes;
      FillSamples(to, size, this->FindFill(), valueSize);
      to += size;
      row = last;
      continue;
    }
    const bool hasCode = this->HasCodeOf(*found);
    if (hasCode && !isWhole)
    {
      this->Scratch.resize(stripBytes);
    }
    std::uint8_t* strip = isWhole ? to : this->Scratch.data();
    if (!hasCode ||
      ::TIFFReadEncodedStrip(tiff, number, strip, static_cast<tmsize_t>(stripBytes)) !=
        static_cast<tmsize_t>(stripBytes))
    {
      return this->MakeError(
        StatusCode::Corrupt, "the strip of row " + std::to_string(first) + " is truncated");
    }
    for (std::int64_t copied = row; !isWhole && copied < last; ++copied)
    {
      std::memcpy(to + static_cast<std::size_t>(copied - row) * bytes,
        strip + static_cast<std::size_t>(copied - first) * rowBytes +
          static_cast<std::size_t>(rectangle.LowX) * valueSize,
        bytes);
    }
    to += static_cast<std::size_t>(last - row) * bytes;
    row = last;
  }
  return Status::Ok();
}

Status TiffFile::ReadTiles(const TiffRectangle& rectangle, std::uint8_t* to)
{
  ::TIFF* tiff = this->Tiff->Tiff;
  const std::size_t valueSize = GetValueSize(this->Format.Type);
  const auto bytes = static_cast<std::size_t>(rectangle.HighX - rectangle.LowX) * valueSize;
  const std::int64_t width = this->Tiff->Get<std::uint32_t>(TIFFTAG_TILEWIDTH, 0);
  const std::int64_t height = this->Tiff->Get<std::uint32_t>(TIFFTAG_TILELENGTH, 0);
  const tmsize_t tileBytes = ::TIFFTileSize(tiff);
  if (width < 1 || height < 1 || tileBytes <= 0 ||
    static_cast<std::uint64_t>(tileBytes) / valueSize / static_cast<std::uint64_t>(width) !=
      static_cast<std::uint64_t>(height))
  {
    return this->MakeError(StatusCode::Corrupt, "the size of its tiles is impossible");
  }
  for (std::int64_t y = rectangle.LowY / height * height; y < rectangle.HighY; y += height)
  {
    for (std::int64_t x = rectangle.LowX / width * width; x < rectangle.HighX; x += width)
    {
      const std::uint32_t tile =
        ::TIFFComputeTile(tiff, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), 0, 0);
      const auto found = this->FindStrile(tile);
      ISOSURFACE_RETURN_IF_ERROR(found.GetStatus());
      const bool hasCode = !found->IsAbsent() && this->HasCodeOf(*found);
      this->Scratch.resize(hasCode ? static_cast<std::size_t>(tileBytes) : this->Scratch.size());
      if (!found->IsAbsent() &&
        (!hasCode ||
          ::TIFFReadEncodedTile(tiff, tile, this->Scratch.data(), tileBytes) != tileBytes))
      {
        return this->MakeError(
          StatusCode::Corrupt, "tile " + std::to_string(tile) + " is truncated");
      }
      const auto fill = found->IsAbsent() ? this->FindFill() : std::array<std::uint8_t, 8>();
      const std::int64_t left = std::max(x, rectangle.LowX);
      const std::int64_t right = std::min(x + width, rectangle.HighX);
      const std::size_t size = static_cast<std::size_t>(right - left) * valueSize;
      for (std::int64_t row = std::max(y, rectangle.LowY);
           row < std::min(y + height, rectangle.HighY); ++row)
      {
        std::uint8_t* const samples = to + static_cast<std::size_t>(row - rectangle.LowY) * bytes +
          static_cast<std::size_t>(left - rectangle.LowX) * valueSize;
        if (found->IsAbsent())
        {
          FillSamples(samples, size, fill, valueSize);
          continue;
        }
        std::memcpy(samples,
          this->Scratch.data() + static_cast<std::size_t>((row - y) * width + left - x) * valueSize,
          size);
      }
    }
  }
  return Status::Ok();
}

} // namespace isosurface
