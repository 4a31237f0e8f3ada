// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomSlice.h"

#include "Formats/Dicom/DicomCompression.h"
#include "Formats/Dicom/DicomDataSet.h"
#include "Formats/Dicom/DicomImageFile.h"
#include "Ground/Base/FileSystem.h"

#include <gdcmImageReader.h>
#include <gdcmMediaStorage.h>
#include <gdcmTrace.h>
#include <gdcmTransferSyntax.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <istream>
#include <limits>
#include <mutex>
#include <optional>
#include <sstream>
#include <streambuf>

namespace isosurface
{
namespace
{

constexpr std::int64_t MaximumSide = 65536;

Status MakeError(const std::string& path, const std::string& reason)
{
  return Status(StatusCode::Corrupt, path + ": cannot be read: " + reason);
}

gdcm::TransferSyntax::TSType FindSyntax(const DicomSlice& slice)
{
  return gdcm::TransferSyntax::GetTSType(slice.Syntax.c_str());
}

/// A step of the last digit of a decimal number.
double FindUnit(const std::string& number)
{
  const std::size_t exponent = std::min(number.find_first_of("eE"), number.size());
  const std::size_t point = std::min(number.find('.'), exponent);
  const std::size_t last = std::min(number.find_last_of("0123456789", exponent), exponent);
  const double decimals = point < last ? static_cast<double>(last - point) : 0;
  const double scale = exponent < number.size() ? std::atof(number.c_str() + exponent + 1) : 0;
  return std::pow(10, scale - decimals);
}

void TakePlace(const DicomDataSet& tags, DicomSlice& slice)
{
  const auto position = tags.GetNumbers(0x00200032, 3);
  const auto orientation = tags.GetNumbers(0x00200037, 6);
  slice.HasPlace = position && orientation;
  if (slice.HasPlace)
  {
    std::copy(position->begin(), position->end(), slice.Position.begin());
    std::istringstream numbers(tags.GetText(0x00200032));
    slice.PositionUnit = std::numeric_limits<double>::max();
    for (std::string number; std::getline(numbers, number, '\\');)
    {
      slice.PositionUnit = std::min(slice.PositionUnit, FindUnit(number));
    }
    std::copy_n(orientation->begin(), 3, slice.AlongRow.begin());
    std::copy_n(orientation->begin() + 3, 3, slice.AlongColumn.begin());
  }
  if (const auto distances = tags.GetNumbers(0x00280030, 2))
  {
    slice.RowDistance = (*distances)[0];
    slice.ColumnDistance = (*distances)[1];
  }
}

/// Other bits than the lowest are not what GDCM would take.
Status CheckBits(const DicomDataSet& tags, const DicomSlice& slice)
{
  const bool isPart = slice.Type == ValueType::Int16 || slice.Type == ValueType::UInt16;
  const double highest = tags.GetNumber(0x00280102, slice.BitsStored - 1);
  if (isPart && slice.BitsStored < 16 && highest != slice.BitsStored - 1)
  {
    return Status(StatusCode::Unsupported,
      slice.Path + ": cannot be read: its samples are not in the lowest bits");
  }
  return Status::Ok();
}

Status TakeHeader(const DicomDataSet& tags, DicomSlice& slice)
{
  slice.Series = tags.GetText(0x0020000e);
  slice.Description = tags.GetText(0x0008103e);
  slice.Photometric = tags.GetText(0x00280004);
  slice.Syntax = tags.GetSyntax();
  if (FindSyntax(slice) == gdcm::TransferSyntax::TS_END)
  {
    return Status(StatusCode::Unsupported,
      slice.Path + ": cannot be read: its transfer syntax " + slice.Syntax + " is not supported");
  }
  const double rows = tags.GetNumber(0x00280010, 0);
  const double columns = tags.GetNumber(0x00280011, 0);
  const double frames = tags.GetNumber(0x00280008, 1);
  if (!(rows >= 1 && rows < MaximumSide && columns >= 1 && columns < MaximumSide && frames >= 1 &&
        frames < 1e9))
  {
    return MakeError(slice.Path, "its numbers of rows and columns are impossible");
  }
  slice.Rows = static_cast<std::int64_t>(rows);
  slice.Columns = static_cast<std::int64_t>(columns);
  slice.Frames = static_cast<std::int64_t>(frames);
  slice.Channels = static_cast<int>(std::clamp(tags.GetNumber(0x00280002, 1), 0.0, 100.0));
  const auto bits = static_cast<int>(std::clamp(tags.GetNumber(0x00280100, 0), 0.0, 100.0));
  const bool isSigned = tags.GetNumber(0x00280103, 0) != 0;
  const auto type = bits == 8 || bits == 16 || bits == 32
    ? FindIntegerType(static_cast<std::size_t>(bits) / 8, isSigned)
    : std::nullopt;
  if (!type)
  {
    return Status(StatusCode::Unsupported,
      slice.Path + ": cannot be read: its samples have " + std::to_string(bits) + " bits");
  }
  slice.Type = *type;
  slice.BitsStored =
    static_cast<int>(std::clamp<double>(tags.GetNumber(0x00280101, bits), 1, bits));
  slice.Scale = { tags.GetNumber(0x00281053, 1), tags.GetNumber(0x00281052, 0) };
  // The images of CT say which type they have if it is not this one (PS3.3, C.8.2.1).
  const std::string scaledTo = tags.GetText(0x00281054);
  slice.IsHounsfield = scaledTo == "HU" || (scaledTo.empty() && tags.GetText(0x00080060) == "CT");
  TakePlace(tags, slice);
  return CheckBits(tags, slice);
}

/// Whether what could be read of the file is that of an image, or tells nothing.
bool IsImage(const DicomDataSet& tags)
{
  std::string storage = tags.GetText(0x00020002);
  storage = storage.empty() ? tags.GetText(0x00080016) : storage;
  const auto type = gdcm::MediaStorage::GetMSType(storage.c_str());
  return storage.empty() || gdcm::MediaStorage::IsImage(type);
}

std::uint64_t GetImageSize(const DicomSlice& slice)
{
  return static_cast<std::uint64_t>(slice.Rows) * static_cast<std::uint64_t>(slice.Columns) *
    GetValueSize(slice.Type);
}

/// Some files have samples that are not compressed although they say otherwise.
Status CheckPixels(const DicomDataSet& tags, const DicomSlice& slice)
{
  const bool saysFragments = gdcm::TransferSyntax(FindSyntax(slice)).IsEncapsulated();
  const bool isOther = tags.HasFragments()
    ? !saysFragments
    : saysFragments && tags.GetPixelSize() > GetImageSize(slice) + 1;
  return isOther ? MakeError(slice.Path,
                     "its image is damaged: its pixels are not what its transfer syntax " +
                       slice.Syntax + " says")
                 : Status::Ok();
}

/// Overlays may be in the bits above those of 16 that are stored.
void ClearUnusedBits(const DicomSlice& slice, std::vector<std::uint8_t>& samples)
{
  const int unused = 16 - slice.BitsStored;
  if (GetValueSize(slice.Type) != 2 || unused == 0)
  {
    return;
  }
  for (std::size_t at = 0; at < samples.size(); at += 2)
  {
    std::uint16_t bits;
    std::memcpy(&bits, samples.data() + at, 2);
    const auto highest = static_cast<std::uint16_t>(bits << unused);
    bits = slice.Type == ValueType::Int16
      ? static_cast<std::uint16_t>(static_cast<std::int16_t>(highest) >> unused)
      : static_cast<std::uint16_t>(highest >> unused);
    std::memcpy(samples.data() + at, &bits, 2);
  }
}

/// Samples that are not compressed.
Status ReadSamples(const DicomSlice& slice, DicomDataSet& tags, std::vector<std::uint8_t>& to)
{
  const auto size = static_cast<std::size_t>(GetImageSize(slice));
  const bool isBigEndian =
    tags.IsBigEndian() || FindSyntax(slice) == gdcm::TransferSyntax::ImplicitVRBigEndianPrivateGE;
  // Samples of 8 bits may be in words of 16, the first of two in the low byte.
  const std::size_t word =
    std::max<std::size_t>(tags.HasBigEndianWords() ? 2 : 1, GetValueSize(slice.Type));
  const std::size_t whole = (size + word - 1) / word * word;
  to.clear();
  ISOSURFACE_RETURN_IF_ERROR(tags.AppendPixels(tags.GetPixelSize() < whole ? size : whole, to));
  for (std::size_t end = word; isBigEndian && end <= to.size(); end += word)
  {
    const auto last = to.begin() + static_cast<std::ptrdiff_t>(end);
    std::reverse(last - static_cast<std::ptrdiff_t>(word), last);
  }
  to.resize(size);
  return Status::Ok();
}

/// Samples by run lengths.
Status ReadRunLengths(const DicomSlice& slice, DicomDataSet& tags, std::vector<std::uint8_t>& to)
{
  const std::size_t valueSize = GetValueSize(slice.Type);
  std::vector<std::uint8_t> code;
  ISOSURFACE_RETURN_IF_ERROR(tags.AppendPixels(0, code));
  to.clear();
  return DecodeRunLengths(code, GetImageSize(slice) / valueSize, valueSize, to)
    ? Status::Ok()
    : MakeError(slice.Path, "its image is damaged: its run lengths are damaged or truncated");
}

/// A buffer of bytes that GDCM reads.
class MemoryBuffer : public std::streambuf
{
public:
  explicit MemoryBuffer(std::vector<std::uint8_t>& bytes)
  {
    auto* const begin = reinterpret_cast<char*>(bytes.data());
    this->setg(begin, begin, begin + bytes.size());
  }

protected:
  pos_type seekoff(off_type by, std::ios_base::seekdir from, std::ios_base::openmode) override
  {
    const off_type size = this->egptr() - this->eback();
    const off_type at = by +
      (from == std::ios_base::cur      ? this->gptr() - this->eback()
          : from == std::ios_base::end ? size
                                       : 0);
    if (at < 0 || at > size)
    {
      return pos_type(off_type(-1));
    }
    this->setg(this->eback(), this->eback() + at, this->egptr());
    return pos_type(at);
  }
  pos_type seekpos(pos_type at, std::ios_base::openmode mode) override
  {
    return this->seekoff(off_type(at), std::ios_base::beg, mode);
  }
};

void BeQuiet()
{
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  gdcm::Trace::DebugOff();
}

} // namespace

Result<DicomSlice> DicomSlice::Read(const std::string& path, std::string* series)
{
  ISOSURFACE_RETURN_IF_ERROR(GetLocalFileSystem().CheckRegular(path, "read"));
  const auto bytes = GetLocalFileSystem().OpenForReading(path);
  ISOSURFACE_RETURN_IF_ERROR(bytes.GetStatus());
  DicomDataSet tags(**bytes);
  const Status read = tags.ReadHeader();
  if (series)
  {
    *series = tags.GetText(0x0020000e);
  }
  DicomSlice slice;
  slice.Path = path;
  if (read.IsOk() && tags.Has(0x00280010))
  {
    ISOSURFACE_RETURN_IF_ERROR(TakeHeader(tags, slice));
    return slice;
  }
  if (!read.IsOk() && read.GetCode() != StatusCode::Corrupt &&
    read.GetCode() != StatusCode::NotFound)
  {
    return read;
  }
  if (tags.HasMagic() && IsImage(tags))
  {
    return read.IsOk() ? MakeError(path, "its header is damaged: it has no rows") : read;
  }
  return Status(StatusCode::NotFound, path + ": cannot be read: it is no image of DICOM");
}

Status DicomSlice::Decode(std::vector<std::uint8_t>& to) const
{
  const auto file = GetLocalFileSystem().OpenForReading(this->Path);
  ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
  DicomDataSet tags(**file);
  ISOSURFACE_RETURN_IF_ERROR(tags.ReadHeader());
  ISOSURFACE_RETURN_IF_ERROR(CheckPixels(tags, *this));
  if (!tags.HasFragments() || FindSyntax(*this) == gdcm::TransferSyntax::RLELossless)
  {
    ISOSURFACE_RETURN_IF_ERROR(
      tags.HasFragments() ? ReadRunLengths(*this, tags, to) : ReadSamples(*this, tags, to));
    ClearUnusedBits(*this, to);
    return Status::Ok();
  }
  DicomImageFile plain(*this);
  ISOSURFACE_RETURN_IF_ERROR(plain.TakePixels(tags));
  // GDCM promises nothing about threads.
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
  BeQuiet();
  try
  {
    MemoryBuffer memory(plain.GetBytes());
    std::istream stream(&memory);
    gdcm::ImageReader reader;
    reader.SetStream(stream);
    if (!reader.Read())
    {
      return MakeError(this->Path,
        "its image is damaged or truncated, or its transfer syntax " + this->Syntax +
          " is not supported");
    }
    const gdcm::Image& image = reader.GetImage();
    const unsigned int* size = image.GetDimensions();
    const auto bytes = static_cast<std::size_t>(GetImageSize(*this));
    if (size[0] != this->Columns || size[1] != this->Rows || image.GetBufferLength() != bytes)
    {
      return MakeError(this->Path, "its image is of another size than its header says");
    }
    to.resize(bytes);
    if (!image.GetBuffer(reinterpret_cast<char*>(to.data())))
    {
      return MakeError(this->Path, "its image cannot be decoded: it is damaged or truncated");
    }
  }
  catch (const std::exception& error)
  {
    return MakeError(this->Path, std::string("its image is damaged: ") + error.what());
  }
  return Status::Ok();
}

} // namespace isosurface
