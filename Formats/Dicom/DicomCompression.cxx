// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomCompression.h"

#include "Ground/Base/Coding.h"

#include <algorithm>

namespace isosurface
{
namespace
{

constexpr std::size_t MaximumSegments = 15;
constexpr std::size_t RunHeaderSize = 64;
/// Two bytes are 128 at most.
constexpr std::size_t MaximumRatio = 64;

std::uint64_t LoadBigEndian(const std::uint8_t* bytes, std::size_t size)
{
  std::uint64_t number = 0;
  for (std::size_t byte = 0; byte < size; ++byte)
  {
    number = number << 8 | bytes[byte];
  }
  return number;
}

/// One byte of each sample: runs and literal bytes (PackBits). `end` is that of the segment.
bool DecodeSegment(const std::uint8_t* begin, const std::uint8_t* end, std::size_t count,
  std::size_t step, std::uint8_t* to)
{
  while (count > 0)
  {
    if (end - begin < 2)
    {
      return false;
    }
    const std::size_t control = *begin++;
    if (control == 128)
    {
      continue;
    }
    const bool isRun = control > 128;
    const std::size_t length = isRun ? 257 - control : control + 1;
    const auto stored = static_cast<std::size_t>(end - begin);
    const std::size_t taken = std::min(length, count); // an even number of bytes may be coded
    if (stored < (isRun ? 1 : taken))
    {
      return false;
    }
    for (std::size_t byte = 0; byte < taken; ++byte, to += step)
    {
      *to = begin[isRun ? 0 : byte];
    }
    begin += std::min(stored, isRun ? 1 : length);
    count -= taken;
  }
  return true;
}

/// Where the codestream of JPEG 2000 begins: at once, or in one of the boxes of a JP2 file, each with
/// its length, its kind and its contents. `size` if it has none.
std::size_t FindCodestream(const std::uint8_t* bytes, std::size_t size)
{
  constexpr std::uint64_t signatureBox = 0x6a502020;
  constexpr std::uint64_t codestreamBox = 0x6a703263;
  if (size < 8 || LoadBigEndian(bytes + 4, 4) != signatureBox)
  {
    return 0;
  }
  for (std::size_t at = 0; size - at >= 16;)
  {
    const std::uint64_t shortLength = LoadBigEndian(bytes + at, 4);
    const bool isLong = shortLength == 1;
    if (LoadBigEndian(bytes + at + 4, 4) == codestreamBox)
    {
      return at + (isLong ? 16 : 8);
    }
    const std::uint64_t length = isLong ? LoadBigEndian(bytes + at + 8, 8) : shortLength;
    if (length < 8 || length > size - at)
    {
      return size;
    }
    at += static_cast<std::size_t>(length);
  }
  return size;
}

std::optional<CompressedForm> FindJpegForm(const std::uint8_t* bytes, std::size_t size)
{
  for (std::size_t at = 2; at + 10 <= size && bytes[at] == 0xff;)
  {
    const std::uint8_t marker = bytes[at + 1];
    const bool isFrame =
      (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) ||
      marker == 0xf7;
    if (isFrame)
    {
      return CompressedForm{ { LoadBigEndian(bytes + at + 7, 2), LoadBigEndian(bytes + at + 5, 2),
                               bytes[at + 9] },
        bytes[at + 4], false, marker != 0xf7 };
    }
    // Fill bytes stand alone. Other markers without a length have no place before the frame, but
    // decoders skip them.
    if (marker < 0xc0 || (marker >= 0xd0 && marker <= 0xd9))
    {
      return std::nullopt;
    }
    at += marker == 0xff ? 1 : 2 + static_cast<std::size_t>(LoadBigEndian(bytes + at + 2, 2));
  }
  return std::nullopt;
}

} // namespace

std::optional<CompressedForm> FindCompressedForm(const std::uint8_t* bytes, std::size_t size)
{
  if (size >= 2 && LoadBigEndian(bytes, 2) == 0xffd8)
  {
    return FindJpegForm(bytes, size);
  }
  const std::size_t begin = FindCodestream(bytes, size);
  const std::uint8_t* const code = bytes + begin;
  if (size - begin < 43 || LoadBigEndian(code, 4) != 0xff4fff51)
  {
    return std::nullopt;
  }
  return CompressedForm{ { LoadBigEndian(code + 8, 4) - LoadBigEndian(code + 16, 4),
                           LoadBigEndian(code + 12, 4) - LoadBigEndian(code + 20, 4),
                           LoadBigEndian(code + 40, 2) },
    1 + (code[42] & 0x7f), (code[42] & 0x80) != 0 };
}

bool DecodeRunLengths(const std::vector<std::uint8_t>& code, std::size_t count,
  std::size_t valueSize, std::vector<std::uint8_t>& to)
{
  if (code.size() < RunHeaderSize || LoadLittleEndian<std::uint32_t>(code.data()) != valueSize ||
    valueSize > MaximumSegments || count > MaximumRatio * code.size() / valueSize)
  {
    return false;
  }
  const std::size_t before = to.size();
  to.resize(before + count * valueSize);
  for (std::size_t segment = 0; segment < valueSize; ++segment)
  {
    const std::uint8_t* const header = code.data() + 4 * (segment + 1);
    const std::size_t begin = LoadLittleEndian<std::uint32_t>(header);
    const std::size_t next = LoadLittleEndian<std::uint32_t>(header + 4);
    const std::size_t end = segment + 1 < valueSize ? next : code.size();
    // The first segment has the highest bytes.
    if (begin < RunHeaderSize || begin > end || end > code.size() ||
      !DecodeSegment(code.data() + begin, code.data() + end, count, valueSize,
        to.data() + before + valueSize - 1 - segment))
    {
      return false;
    }
  }
  return true;
}

} // namespace isosurface
