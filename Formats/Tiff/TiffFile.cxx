// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffFile.h"

#include "Formats/Source/TextFields.h"
#include "Formats/Tiff/TiffHandle.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <optional>
#include <type_traits>

namespace isosurface
{
namespace
{

/// The maximum number of rows and columns.
constexpr std::uint64_t MaximumSize = std::uint64_t{ 1 } << 31;
/// The maximum size of a page. Four times as much is a number, too.
constexpr std::uint64_t MaximumPageBytes = std::uint64_t{ 1 } << 60;
/// The tag with which GDAL says what samples are that do not exist: a number as text.
constexpr std::uint32_t NoDataTag = 42113;

/// What colours samples are of; null if they are grey.
const char* FindColors(std::uint16_t photometric)
{
  switch (photometric)
  {
    case PHOTOMETRIC_MINISBLACK:
    case PHOTOMETRIC_MINISWHITE:
      return nullptr;
    case PHOTOMETRIC_RGB:
      return "RGB";
    case PHOTOMETRIC_PALETTE:
      return "a palette";
    case PHOTOMETRIC_MASK:
      return "a transparency mask";
    case PHOTOMETRIC_SEPARATED:
      return "CMYK";
    case PHOTOMETRIC_YCBCR:
      return "YCbCr";
    case PHOTOMETRIC_CFA:
      return "a colour filter array";
    default:
      return "another PhotometricInterpretation than 0 and 1";
  }
}

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
  , IsOfImageJ(this->FindDescription().rfind("ImageJ=", 0) == 0)
{
}

TiffFile::~TiffFile() = default;

Result<std::unique_ptr<TiffFile>> TiffFile::Open(FileSystem& files, const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, files.OpenForReading(path));
  ISOSURFACE_ASSIGN_OR_RETURN(auto handle, TiffHandle::Open(std::move(file)));
  return std::unique_ptr<TiffFile>(new TiffFile(std::move(handle)));
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
  const auto samples = tiff.Get<std::uint16_t>(TIFFTAG_SAMPLESPERPIXEL, 1);
  const auto photometric = tiff.Get<std::uint16_t>(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  if (const char* const colors = FindColors(photometric);
      colors && !(photometric == PHOTOMETRIC_PALETTE && this->IsOfImageJ))
  {
    return this->MakeError(StatusCode::Unsupported,
      "it has " + std::to_string(samples) + " samples a pixel, which are colours (" + colors +
        "); only grey ones are supported");
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
  const bool isSeparate =
    tiff.Get<std::uint16_t>(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) == PLANARCONFIG_SEPARATE;
  TiffFormat found = { static_cast<std::int64_t>(width), static_cast<std::int64_t>(height), *type,
    isSeparate ? 1 : samples, isSeparate ? samples : 1 };
  if (samples == 0 || std::uint64_t{ width } * height > MaximumPageBytes / found.GetPixelBytes())
  {
    return this->MakeError(StatusCode::Corrupt, "its width or height is impossible");
  }
  return found;
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
    static_cast<std::uint64_t>(format.Height) * format.GetPixelBytes();
  if (scratch <= 0 ||
    static_cast<std::uint64_t>(scratch) > 4 * pageBytes + TiffHandle::MaximumTableSize)
  {
    return this->MakeError(StatusCode::Corrupt, "the size of its strips or tiles is impossible");
  }
  // Uncompressed and compressed.
  return 2 * static_cast<std::uint64_t>(scratch);
}

Status TiffFile::TakeFormat(const TiffPage& first)
{
  if (::TIFFSetSubDirectory(this->Tiff->Tiff, first.Directory) != 1)
  {
    return this->MakeError(StatusCode::Corrupt, "its directory cannot be read");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto format, this->ReadFormat());
  ISOSURFACE_ASSIGN_OR_RETURN(const auto scratch, this->FindScratchBytes(format));
  this->Format = format;
  this->Unit = this->FindUnit();
  this->ScratchBytes = scratch;
  return Status::Ok();
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
    return this->ReadTiles(page, rectangle, to);
  }
  const auto compression = this->Tiff->Get<std::uint16_t>(TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  const auto order = this->Tiff->Get<std::uint16_t>(TIFFTAG_FILLORDER, FILLORDER_MSB2LSB);
  return compression == COMPRESSION_NONE && order == FILLORDER_MSB2LSB
    ? this->ReadRows(page, rectangle, to)
    : this->ReadStrips(page, rectangle, to);
}

/// Rows that stand in the file as they are.
Status TiffFile::ReadRows(const TiffPage& page, const TiffRectangle& rectangle, std::uint8_t* to)
{
  ::TIFF* tiff = this->Tiff->Tiff;
  const std::uint64_t valueSize = GetValueSize(this->Format.Type);
  const std::uint64_t pixelBytes = this->Format.GetPixelBytes();
  const std::uint64_t rowBytes = static_cast<std::uint64_t>(this->Format.Width) * pixelBytes;
  const bool isWhole = rectangle.LowX == 0 && rectangle.HighX == this->Format.Width;
  const auto bytes = static_cast<std::size_t>(rectangle.HighX - rectangle.LowX) *
    static_cast<std::size_t>(pixelBytes);
  const std::int64_t rowsPerStrip = std::max<std::int64_t>(1,
    std::min<std::int64_t>(
      this->Tiff->Get<std::uint32_t>(TIFFTAG_ROWSPERSTRIP, 1), this->Format.Height));
  for (std::int64_t row = rectangle.LowY; row < rectangle.HighY;)
  {
    const std::int64_t number = row / rowsPerStrip;
    const std::int64_t end = std::min(rectangle.HighY, (number + 1) * rowsPerStrip);
    const std::int64_t rows = isWhole ? end - row : 1;
    const std::size_t size = bytes * static_cast<std::size_t>(rows);
    ISOSURFACE_ASSIGN_OR_RETURN(const auto strip,
      this->FindStrile(::TIFFComputeStrip(tiff, static_cast<std::uint32_t>(row), page.Plane)));
    const auto skipped = static_cast<std::uint64_t>(row - number * rowsPerStrip);
    if (strip.IsAbsent())
    {
      FillSamples(to, size, this->FindFill(), valueSize);
    }
    else if (strip.Offset == 0 ||
      strip.Size / rowBytes < skipped + static_cast<std::uint64_t>(rows))
    {
      return this->MakeError(StatusCode::Corrupt,
        "the strip of row " + std::to_string(number * rowsPerStrip) + " is truncated: it has " +
          std::to_string(strip.Size) + " bytes");
    }
    else
    {
      const std::uint64_t offset = strip.Offset + page.Shift + skipped * rowBytes +
        static_cast<std::uint64_t>(rectangle.LowX) * pixelBytes;
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

std::string TiffFile::FindNoData() const
{
  const auto [count, found] = this->Tiff->FindUnknown(NoDataTag);
  const std::string text = found ? std::string(static_cast<const char*>(found), count) : "";
  return TrimText(text.substr(0, text.find('\0')));
}

std::array<std::uint8_t, 8> TiffFile::FindFill() const
{
  const std::string text = this->FindNoData();
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

Status TiffFile::ReadStrips(const TiffPage& page, const TiffRectangle& rectangle, std::uint8_t* to)
{
  ::TIFF* tiff = this->Tiff->Tiff;
  const std::size_t valueSize = GetValueSize(this->Format.Type);
  const std::size_t pixelBytes = this->Format.GetPixelBytes();
  const std::size_t rowBytes = static_cast<std::size_t>(this->Format.Width) * pixelBytes;
  const auto bytes = static_cast<std::size_t>(rectangle.HighX - rectangle.LowX) * pixelBytes;
  const std::int64_t rowsPerStrip = std::max<std::int64_t>(1,
    std::min<std::int64_t>(
      this->Tiff->Get<std::uint32_t>(TIFFTAG_ROWSPERSTRIP, 1), this->Format.Height));
  for (std::int64_t row = rectangle.LowY; row < rectangle.HighY;)
  {
    const std::int64_t first = row / rowsPerStrip * rowsPerStrip;
    const std::int64_t end = std::min(first + rowsPerStrip, this->Format.Height);
    const std::size_t stripBytes = static_cast<std::size_t>(end - first) * rowBytes;
    const bool isWhole = row == first && end <= rectangle.HighY && rowBytes == bytes;
    const std::uint32_t number =
      ::TIFFComputeStrip(tiff, static_cast<std::uint32_t>(first), page.Plane);
    const std::int64_t last = std::min(end, rectangle.HighY);
    ISOSURFACE_ASSIGN_OR_RETURN(const auto found, this->FindStrile(number));
    if (found.IsAbsent())
    {
      const std::size_t size = static_cast<std::size_t>(last - row) * bytes;
      FillSamples(to, size, this->FindFill(), valueSize);
      to += size;
      row = last;
      continue;
    }
    const bool hasCode = this->HasCodeOf(found);
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
          static_cast<std::size_t>(rectangle.LowX) * pixelBytes,
        bytes);
    }
    to += static_cast<std::size_t>(last - row) * bytes;
    row = last;
  }
  return Status::Ok();
}

Status TiffFile::ReadTiles(const TiffPage& page, const TiffRectangle& rectangle, std::uint8_t* to)
{
  ::TIFF* tiff = this->Tiff->Tiff;
  const std::size_t valueSize = GetValueSize(this->Format.Type);
  const std::size_t pixelBytes = this->Format.GetPixelBytes();
  const auto bytes = static_cast<std::size_t>(rectangle.HighX - rectangle.LowX) * pixelBytes;
  const std::int64_t width = this->Tiff->Get<std::uint32_t>(TIFFTAG_TILEWIDTH, 0);
  const std::int64_t height = this->Tiff->Get<std::uint32_t>(TIFFTAG_TILELENGTH, 0);
  const tmsize_t tileBytes = ::TIFFTileSize(tiff);
  if (width < 1 || height < 1 || tileBytes <= 0 ||
    static_cast<std::uint64_t>(tileBytes) / pixelBytes / static_cast<std::uint64_t>(width) !=
      static_cast<std::uint64_t>(height))
  {
    return this->MakeError(StatusCode::Corrupt, "the size of its tiles is impossible");
  }
  for (std::int64_t y = rectangle.LowY / height * height; y < rectangle.HighY; y += height)
  {
    for (std::int64_t x = rectangle.LowX / width * width; x < rectangle.HighX; x += width)
    {
      const std::uint32_t tile = ::TIFFComputeTile(
        tiff, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), 0, page.Plane);
      ISOSURFACE_ASSIGN_OR_RETURN(const auto found, this->FindStrile(tile));
      const bool hasCode = !found.IsAbsent() && this->HasCodeOf(found);
      this->Scratch.resize(hasCode ? static_cast<std::size_t>(tileBytes) : this->Scratch.size());
      if (!found.IsAbsent() &&
        (!hasCode ||
          ::TIFFReadEncodedTile(tiff, tile, this->Scratch.data(), tileBytes) != tileBytes))
      {
        return this->MakeError(
          StatusCode::Corrupt, "tile " + std::to_string(tile) + " is truncated");
      }
      const auto fill = found.IsAbsent() ? this->FindFill() : std::array<std::uint8_t, 8>();
      const std::int64_t left = std::max(x, rectangle.LowX);
      const std::int64_t right = std::min(x + width, rectangle.HighX);
      const std::size_t size = static_cast<std::size_t>(right - left) * pixelBytes;
      for (std::int64_t row = std::max(y, rectangle.LowY);
           row < std::min(y + height, rectangle.HighY); ++row)
      {
        std::uint8_t* const samples = to + static_cast<std::size_t>(row - rectangle.LowY) * bytes +
          static_cast<std::size_t>(left - rectangle.LowX) * pixelBytes;
        if (found.IsAbsent())
        {
          FillSamples(samples, size, fill, valueSize);
          continue;
        }
        std::memcpy(samples,
          this->Scratch.data() +
            static_cast<std::size_t>((row - y) * width + left - x) * pixelBytes,
          size);
      }
    }
  }
  return Status::Ok();
}

} // namespace isosurface
