// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeFile/DicomSlice.h"

#include "Base/FileSystem.h"
#include "Source/HeaderText.h"

#include <gdcmImageReader.h>
#include <gdcmMediaStorage.h>
#include <gdcmReader.h>
#include <gdcmStringFilter.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <fstream>
#include <optional>
#include <set>

namespace isosurface
{
namespace
{

constexpr std::int64_t MaximumSide = 65536;

const gdcm::Tag RowsTag(0x0028, 0x0010);

/// Texts of tags.
class TagReader
{
public:
  explicit TagReader(const gdcm::File& file) { this->Filter.SetFile(file); }

  std::string GetText(std::uint16_t group, std::uint16_t element)
  {
    std::string text = this->Filter.ToString(gdcm::Tag(group, element));
    text.erase(std::remove(text.begin(), text.end(), '\0'), text.end());
    return HeaderText::Trim(text);
  }
  std::optional<std::vector<double>> GetNumbers(
    std::uint16_t group, std::uint16_t element, std::size_t count)
  {
    std::string text = this->GetText(group, element);
    std::replace(text.begin(), text.end(), '\\', ' ');
    return HeaderText::ParseDoubles(text, count);
  }
  double GetNumber(std::uint16_t group, std::uint16_t element, double otherwise)
  {
    const auto number = this->GetNumbers(group, element, 1);
    return number && std::isfinite((*number)[0]) ? (*number)[0] : otherwise;
  }

private:
  gdcm::StringFilter Filter;
};

Status MakeError(const std::string& path, const std::string& reason)
{
  return Status(StatusCode::Corrupt, path + ": cannot be read: " + reason);
}

void TakePlace(TagReader& tags, DicomSlice& slice)
{
  const auto position = tags.GetNumbers(0x0020, 0x0032, 3);
  const auto orientation = tags.GetNumbers(0x0020, 0x0037, 6);
  slice.HasPlace = position && orientation;
  if (slice.HasPlace)
  {
    std::copy(position->begin(), position->end(), slice.Position.begin());
    std::copy_n(orientation->begin(), 3, slice.AlongRow.begin());
    std::copy_n(orientation->begin() + 3, 3, slice.AlongColumn.begin());
  }
  if (const auto distances = tags.GetNumbers(0x0028, 0x0030, 2))
  {
    slice.RowDistance = (*distances)[0];
    slice.ColumnDistance = (*distances)[1];
  }
}

Status TakeHeader(const gdcm::File& file, DicomSlice& slice)
{
  TagReader tags(file);
  slice.Series = tags.GetText(0x0020, 0x000e);
  slice.Description = tags.GetText(0x0008, 0x103e);
  slice.Photometric = tags.GetText(0x0028, 0x0004);
  slice.Syntax = gdcm::TransferSyntax::GetTSString(file.GetHeader().GetDataSetTransferSyntax());
  const double rows = tags.GetNumber(0x0028, 0x0010, 0);
  const double columns = tags.GetNumber(0x0028, 0x0011, 0);
  const double frames = tags.GetNumber(0x0028, 0x0008, 1);
  if (!(rows >= 1 && rows < MaximumSide && columns >= 1 && columns < MaximumSide && frames >= 1 &&
        frames < 1e9))
  {
    return MakeError(slice.Path, "its numbers of rows and columns are impossible");
  }
  slice.Rows = static_cast<std::int64_t>(rows);
  slice.Columns = static_cast<std::int64_t>(columns);
  slice.Frames = static_cast<std::int64_t>(frames);
  slice.Channels = static_cast<int>(std::clamp(tags.GetNumber(0x0028, 0x0002, 1), 0.0, 100.0));
  const auto bits = static_cast<int>(std::clamp(tags.GetNumber(0x0028, 0x0100, 0), 0.0, 100.0));
  const bool isSigned = tags.GetNumber(0x0028, 0x0103, 0) != 0;
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
    static_cast<int>(std::clamp<double>(tags.GetNumber(0x0028, 0x0101, bits), 1, bits));
  slice.Scale = { tags.GetNumber(0x0028, 0x1053, 1), tags.GetNumber(0x0028, 0x1052, 0) };
  TakePlace(tags, slice);
  return Status::Ok();
}

/// Whether a file has the signature of DICOM.
bool HasMagic(const RandomAccessFile& file)
{
  std::array<char, 4> magic{};
  return file.GetSize() >= 132 && file.Read(128, magic.size(), magic.data()).IsOk() &&
    std::string(magic.data(), magic.size()) == "DICM";
}

/// Whether the part of the file that could be read is that of an image, or tells nothing.
bool IsImage(const gdcm::File& file)
{
  gdcm::MediaStorage storage;
  return !storage.SetFromHeader(file.GetHeader()) || gdcm::MediaStorage::IsImage(storage);
}

void BeQuiet()
{
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  gdcm::Trace::DebugOff();
}

} // namespace

Result<DicomSlice> DicomSlice::Read(const std::string& path)
{
  ISOSURFACE_RETURN_IF_ERROR(GetLocalFileSystem().CheckRegular(path, "read"));
  const auto bytes = GetLocalFileSystem().OpenForReading(path);
  if (!bytes.IsOk())
  {
    return bytes.GetStatus();
  }
  BeQuiet();
  DicomSlice slice;
  slice.Path = path;
  gdcm::Reader reader;
  try
  {
    // Debian's GDCM asserts that a stream is good after it was read: it ends by an exception instead.
    std::ifstream stream(path, std::ios::binary);
    stream.exceptions(std::ios::eofbit | std::ios::failbit | std::ios::badbit);
    reader.SetStream(stream);
    // All that stands before the pixels.
    const bool isRead = reader.ReadUpToTag(gdcm::Tag(0x7fe0, 0x0010), std::set<gdcm::Tag>());
    stream.exceptions(std::ios::goodbit);
    if (isRead && reader.GetFile().GetDataSet().FindDataElement(RowsTag))
    {
      ISOSURFACE_RETURN_IF_ERROR(TakeHeader(reader.GetFile(), slice));
      return slice;
    }
  }
  catch (const std::exception&)
  {
    // As if it were not read.
  }
  if (HasMagic(**bytes) && IsImage(reader.GetFile()))
  {
    return MakeError(path, "its header is truncated or damaged");
  }
  return Status(StatusCode::NotFound, path + ": cannot be read: it is no image of DICOM");
}

Status DicomSlice::Decode(std::vector<std::uint8_t>& to) const
{
  BeQuiet();
  const std::size_t bytes =
    static_cast<std::size_t>(this->Rows * this->Columns) * GetValueSize(this->Type);
  try
  {
    gdcm::ImageReader reader;
    reader.SetFileName(this->Path.c_str());
    if (!reader.Read())
    {
      return MakeError(this->Path,
        "its image is damaged or truncated, or its transfer syntax " + this->Syntax +
          " is not supported");
    }
    const gdcm::Image& image = reader.GetImage();
    const unsigned int* size = image.GetDimensions();
    to.resize(bytes);
    if (size[0] != this->Columns || size[1] != this->Rows || image.GetBufferLength() != bytes ||
      !image.GetBuffer(reinterpret_cast<char*>(to.data())))
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
