// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomSlice.h"

#include "Formats/Dicom/DicomDataSet.h"
#include "Formats/Dicom/DicomImageFile.h"
#include "Ground/Base/FileSystem.h"

#include <cstring>
#include <gdcmImageReader.h>
#include <gdcmMediaStorage.h>
#include <gdcmTrace.h>
#include <gdcmTransferSyntax.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <istream>
#include <limits>
#include <mutex>
#include <sstream>
#include <streambuf>

namespace isosurface
{
namespace
{

/// Which bits of a word are a sample. What is in the others means nothing, or is an overlay.
struct SampleBits
{
  int Low = 0;           ///< the number of the lowest
  int Count = 16;        ///< with Low at most those of the word
  bool IsSigned = false; ///< whether the highest of them is a sign
};

/// Words in the byte order of this machine.
struct SampleWords
{
  const std::uint8_t* First = nullptr;
  std::size_t Size = 2; ///< bytes of each: 1, 2 or 4
  std::size_t Count = 0;
};

template <typename Word>
std::uint32_t LoadWord(const SampleWords& words, std::size_t number)
{
  Word word;
  std::memcpy(&word, words.First + number * sizeof(Word), sizeof(Word));
  return word;
}

/// Calls `use` with a zero of an unsigned type of that size.
template <typename Use>
void DispatchWord(std::size_t size, Use&& use)
{
  size == 1 ? use(std::uint8_t{}) : size == 2 ? use(std::uint16_t{}) : use(std::uint32_t{});
}

/// Makes integers of `valueSize` bytes (1, 2 or 4, no fewer than those of the words) of the samples.
/// `to` may be the words themselves, if they are as large.
/// Source: DICOM PS3.5, 8.1.1.
void TakeSamples(
  const SampleWords& words, const SampleBits& bits, std::size_t valueSize, std::uint8_t* to)
{
  const std::uint32_t mask = bits.Count < 32 ? (std::uint32_t{ 1 } << bits.Count) - 1 : ~0u;
  const std::uint32_t sign = bits.IsSigned ? std::uint32_t{ 1 } << (bits.Count - 1) : 0;
  DispatchWord(words.Size,
    [&](auto someWord)
    {
      DispatchWord(valueSize,
        [&](auto someValue)
        {
          for (std::size_t number = 0; number < words.Count; ++number)
          {
            std::uint32_t sample = LoadWord<decltype(someWord)>(words, number) >> bits.Low & mask;
            sample |= (sample & sign) != 0 ? ~mask : 0;
            const auto value = static_cast<decltype(someValue)>(sample);
            std::memcpy(to + number * sizeof(value), &value, sizeof(value));
          }
        });
    });
}

/// Whether some word has a bit of this number or above.
bool HasBitsFrom(const SampleWords& words, int bit)
{
  std::uint32_t all = 0;
  DispatchWord(words.Size,
    [&](auto some)
    {
      for (std::size_t number = 0; number < words.Count; ++number)
      {
        all |= LoadWord<decltype(some)>(words, number);
      }
    });
  return bit < 32 && all >> bit != 0;
}

constexpr std::int64_t MaximumSide = 65536;
/// Of a compressed image, what may stand before its first sample.
constexpr std::uint64_t MaximumStart = 16384;
constexpr DicomTag MomentTags[] = { 0x00180086, 0x00200100, 0x00200012, 0x00181060, 0x00189087,
  0x00080032, 0x00080033, 0x00080008 };

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

/// The first of several windows; those of a table (VOI LUT Sequence) are none.
void TakeWindow(const DicomDataSet& tags, DicomSlice& slice)
{
  const auto first = [&tags](DicomTag tag)
  {
    const std::string text = tags.GetText(tag);
    return ParseDoubles(text.substr(0, text.find('\\')), 1);
  };
  const auto center = first(0x00281050);
  const auto width = first(0x00281051);
  if (center && width && std::isfinite((*center)[0]) && std::isfinite((*width)[0]) &&
    (*width)[0] > 0)
  {
    slice.WindowCenter = (*center)[0];
    slice.WindowWidth = (*width)[0];
  }
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
    slice.HasDistances = true;
    slice.RowDistance = (*distances)[0];
    slice.ColumnDistance = (*distances)[1];
  }
  slice.SliceDistance = tags.GetNumber(0x00180088, 0);
}

/// Which bits of `allocated` ones are samples.
Status TakeBits(const DicomDataSet& tags, int allocated, DicomSlice& slice)
{
  const bool isSigned = tags.GetNumber(0x00280103, 0) != 0;
  const auto type = allocated == 8 || allocated == 16 || allocated == 32
    ? FindIntegerType(static_cast<std::size_t>(allocated) / 8, isSigned)
    : std::nullopt;
  if (!type)
  {
    return Status(StatusCode::Unsupported,
      slice.Path + ": cannot be read: its samples have " + std::to_string(allocated) + " bits");
  }
  const double stored = tags.GetNumber(0x00280101, allocated);
  const double highest = tags.GetNumber(0x00280102, stored - 1);
  if (!(stored >= 1 && highest >= stored - 1 && highest < allocated))
  {
    return MakeError(slice.Path, "its numbers of bits are impossible");
  }
  slice.Type = *type;
  slice.BitsStored = static_cast<int>(stored);
  slice.LowBit = static_cast<int>(highest - stored) + 1;
  slice.HasOverlay = tags.Has(0x60000102);
  slice.ValueBits = slice.BitsStored;
  return Status::Ok();
}

/// What the header says that nobody obeys.
std::string FindNotes(const DicomDataSet& tags, const DicomSlice& slice)
{
  std::string notes;
  const auto note = [&notes](const std::string& text)
  { notes += (notes.empty() ? "" : "; ") + text; };
  if (slice.Photometric == "MONOCHROME1")
  {
    note("low samples are the bright ones (MONOCHROME1)");
  }
  if (!tags.GetText(0x00280120).empty())
  {
    double padding = tags.GetNumber(0x00280120, 0);
    padding -= slice.IsSigned() && padding > 32767 ? 65536 : 0; // an implicit element has no sign
    std::array<char, 160> text{};
    std::snprintf(text.data(), text.size(),
      "samples where nothing was measured keep their value, %.10g (Pixel Padding Value %.10g)",
      slice.Scale.Slope * padding + slice.Scale.Intercept, padding);
    note(text.data());
  }
  if (slice.HasPlace && !slice.HasDistances)
  {
    note("there is no Pixel Spacing: rows and columns are 1 mm apart");
  }
  if (!tags.GetText(0x3004000e).empty())
  {
    note("samples are not multiplied by the Dose Grid Scaling " + tags.GetText(0x3004000e));
  }
  if (tags.Has(0x00409096))
  {
    note("the Real World Value Mapping is not applied");
  }
  return notes;
}

Status CheckNumbers(const DicomDataSet& tags, const DicomSlice& slice)
{
  if (tags.Has(0x00283000))
  {
    return Status(StatusCode::Unsupported,
      slice.Path + ": cannot be read: its samples go through a table (Modality LUT Sequence)");
  }
  const bool isScale = slice.Scale.Slope != 0;
  const bool isDistance = slice.RowDistance > 0 && slice.ColumnDistance > 0 &&
    std::isfinite(slice.RowDistance) && std::isfinite(slice.ColumnDistance);
  return !isScale ? MakeError(slice.Path, "its Rescale Slope is 0")
    : !isDistance ? MakeError(slice.Path, "its Pixel Spacing is impossible")
                  : Status::Ok();
}

Status TakeHeader(const DicomDataSet& tags, DicomSlice& slice)
{
  slice.Series = tags.GetText(0x0020000e);
  slice.Description = tags.GetText(0x0008103e);
  slice.Modality = tags.GetText(0x00080060);
  slice.SeriesNumber = tags.GetText(0x00200011);
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
  ISOSURFACE_RETURN_IF_ERROR(TakeBits(tags, bits, slice));
  slice.Scale = { tags.GetNumber(0x00281053, 1), tags.GetNumber(0x00281052, 0) };
  // The images of CT say which type they have if it is not HU (PS3.3, C.8.2.1); US is "unspecified".
  slice.Unit = tags.GetText(0x00281054);
  slice.Unit = slice.Unit.empty() ? tags.GetText(0x00541001) : slice.Unit;
  slice.Unit = slice.Unit.empty() && slice.Modality == "CT" ? "HU" : slice.Unit;
  slice.Unit = slice.Unit == "US" ? "" : slice.Unit;
  slice.Frame = tags.GetText(0x00200052);
  TakeWindow(tags, slice);
  TakePlace(tags, slice);
  slice.ImageType = tags.GetText(0x00080008);
  for (std::size_t moment = 0; moment < slice.Moments.size(); ++moment)
  {
    slice.Moments[moment] = tags.GetText(MomentTags[moment]);
  }
  slice.Notes = FindNotes(tags, slice);
  return CheckNumbers(tags, slice);
}

bool IsOfRunLengths(const DicomSlice& slice)
{
  return FindSyntax(slice) == gdcm::TransferSyntax::RLELossless;
}

/// Whether samples are those bits of decoded words that the header tells. Of fewer bits than that, and of
/// JPEG-LS and JPEG 2000, the stream is right where both disagree, unless the header has others for them.
bool HasOtherBits(const DicomSlice& slice, const CompressedForm& form)
{
  return form.Bits > slice.BitsStored && form.Bits >= slice.LowBit + slice.BitsStored &&
    (slice.LowBit > 0 || slice.HasOverlay || form.IsJpeg);
}

Status TakeForm(DicomDataSet& tags, DicomSlice& slice)
{
  if (!tags.HasFragments() || IsOfRunLengths(slice))
  {
    return Status::Ok();
  }
  std::vector<std::uint8_t> start;
  ISOSURFACE_RETURN_IF_ERROR(tags.AppendPixels(MaximumStart, start));
  slice.Form = FindCompressedForm(start.data(), start.size());
  if (!slice.Form)
  {
    return Status::Ok(); // Decode() tells what is wrong
  }
  if (slice.Form->Bits > static_cast<int>(8 * GetValueSize(slice.Type)))
  {
    return Status(StatusCode::Unsupported,
      slice.Path + ": cannot be read: its compressed image has samples of " +
        std::to_string(slice.Form->Bits) + " bits, more than its header allocates");
  }
  slice.ValueBits = HasOtherBits(slice, *slice.Form) ? slice.BitsStored : slice.Form->Bits;
  return Status::Ok();
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

/// Overlays may be in the other bits of the words.
void ClearUnusedBits(const DicomSlice& slice, std::vector<std::uint8_t>& samples)
{
  const std::size_t size = GetValueSize(slice.Type);
  if (slice.BitsStored < static_cast<int>(8 * size))
  {
    TakeSamples({ samples.data(), size, samples.size() / size },
      { slice.LowBit, slice.BitsStored, slice.IsSigned() }, size, samples.data());
  }
}

/// Makes samples of what GDCM has decoded.
Status TakeDecoded(const DicomSlice& slice, const CompressedForm& form, const SampleWords& words,
  std::vector<std::uint8_t>& to)
{
  if (form.IsSigned && !slice.IsSigned() && HasBitsFrom(words, form.Bits - 1))
  {
    return Status(StatusCode::Unsupported,
      slice.Path + ": cannot be read: its image has negative samples, its header unsigned ones");
  }
  SampleBits bits{ 0, form.Bits, slice.IsSigned() };
  // Some encoders clear the bits above those that are stored, and so the sign there.
  const bool isSignStored = bits.IsSigned && !form.IsSigned && form.Bits > slice.BitsStored &&
    !HasBitsFrom(words, slice.BitsStored);
  if (HasOtherBits(slice, form))
  {
    bits = { slice.LowBit, slice.BitsStored, bits.IsSigned };
  }
  else if (isSignStored)
  {
    bits.Count = slice.BitsStored;
  }
  const std::size_t size = GetValueSize(slice.Type);
  to.resize(words.Count * size);
  TakeSamples(words, bits, size, to.data());
  return Status::Ok();
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
  ISOSURFACE_RETURN_IF_ERROR(tags.AppendPixels(std::numeric_limits<std::uint64_t>::max(), code));
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

bool DicomSlice::IsSigned() const
{
  return this->Type == ValueType::Int8 || this->Type == ValueType::Int16 ||
    this->Type == ValueType::Int32;
}

const std::array<const char*, 8> DicomSlice::MomentNames = { "Echo Numbers",
  "Temporal Position Identifier", "Acquisition Number", "Trigger Time", "Diffusion b-value",
  "Acquisition Time", "Content Time", "Image Type" };

Result<DicomSlice> DicomSlice::Read(const std::string& path, std::string* series)
{
  ISOSURFACE_RETURN_IF_ERROR(GetLocalFileSystem().CheckRegular(path, "read"));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto bytes, GetLocalFileSystem().OpenForReading(path));
  DicomDataSet tags(*bytes);
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
    ISOSURFACE_RETURN_IF_ERROR(TakeForm(tags, slice));
    return slice;
  }
  if (!read.IsOk() && read.GetCode() != StatusCode::Corrupt &&
    read.GetCode() != StatusCode::NotFound)
  {
    return read;
  }
  if ((tags.HasMagic() && IsImage(tags)) || tags.Has(0x00280010))
  {
    return read.IsOk() ? MakeError(path, "its header is damaged: it has no rows") : read;
  }
  return Status(StatusCode::NotFound, path + ": cannot be read: it is no image of DICOM");
}

Status DicomSlice::Decode(std::vector<std::uint8_t>& to) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, GetLocalFileSystem().OpenForReading(this->Path));
  DicomDataSet tags(*file);
  ISOSURFACE_RETURN_IF_ERROR(tags.ReadHeader());
  ISOSURFACE_RETURN_IF_ERROR(CheckPixels(tags, *this));
  if (!tags.HasFragments() || IsOfRunLengths(*this))
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
    const std::size_t valueBytes = plain.GetValueBytes();
    const auto count = static_cast<std::size_t>(this->Rows * this->Columns);
    if (size[0] != this->Columns || size[1] != this->Rows ||
      image.GetBufferLength() != count * valueBytes)
    {
      return MakeError(this->Path, "its image is of another size than its header says");
    }
    std::vector<std::uint8_t> decoded(count * valueBytes);
    if (!image.GetBuffer(reinterpret_cast<char*>(decoded.data())))
    {
      return MakeError(this->Path, "its image cannot be decoded: it is damaged or truncated");
    }
    return TakeDecoded(*this, plain.GetForm(), { decoded.data(), valueBytes, count }, to);
  }
  catch (const std::exception& error)
  {
    return MakeError(this->Path, std::string("its image is damaged: ") + error.what());
  }
}

} // namespace isosurface
