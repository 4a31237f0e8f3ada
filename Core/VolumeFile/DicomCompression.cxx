// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeFile/DicomCompression.h"

#include "Base/Coding.h"

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

} // namespace

std::optional<std::array<std::uint64_t, 3>> FindCompressedSize(
  const std::uint8_t* bytes, std::size_t size)
{
  if (size >= 42 && LoadBigEndian(bytes, 4) == 0xff4fff51) // JPEG 2000
  {
    return std::array<std::uint64_t, 3>{ LoadBigEndian(bytes + 8, 4) - LoadBigEndian(bytes + 16, 4),
      LoadBigEndian(bytes + 12, 4) - LoadBigEndian(bytes + 20, 4), LoadBigEndian(bytes + 40, 2) };
  }
  if (size < 4 || LoadBigEndian(bytes, 2) != 0xffd8)
  {
    return std::nullopt;
  }
  for (std::size_t at = 2; at + 10 <= size && bytes[at] == 0xff;)
  {
    const std::uint8_t marker = bytes[at + 1];
    const bool isFrame =
      (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) ||
      marker == 0xf7;
    if (isFrame)
    {
      return std::array<std::uint64_t, 3>{ LoadBigEndian(bytes + at + 7, 2),
        LoadBigEndian(bytes + at + 5, 2), bytes[at + 9] };
    }
    // Fill bytes stand alone; every other segment before the frame has a length.
    at += marker == 0xff ? 1 : 2 + static_cast<std::size_t>(LoadBigEndian(bytes + at + 2, 2));
  }
  return std::nullopt;
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
