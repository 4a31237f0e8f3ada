// SPDX-License-Identifier: BSD-3-Clause
#include "Compositing/PixelRuns.h"

#include "Base/Coding.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace isosurface
{
namespace
{

constexpr std::size_t HeaderSize = 14;
constexpr std::uint32_t AlphaBits = 0xff000000U; // of a color that was loaded little-endian
constexpr std::size_t LongestCount = 5;          // bytes of a LEB128 of 32 bits

std::uint32_t GetBits(float depth)
{
  std::uint32_t bits;
  std::memcpy(&bits, &depth, sizeof(bits));
  return bits;
}

float MakeDepth(std::uint32_t bits)
{
  float depth;
  std::memcpy(&depth, &bits, sizeof(depth));
  return depth;
}

void AppendCount(std::uint32_t count, Message& bytes)
{
  while (count >= 0x80U)
  {
    bytes.push_back(static_cast<std::uint8_t>(count | 0x80U));
    count >>= 7U;
  }
  bytes.push_back(static_cast<std::uint8_t>(count));
}

bool ReadCount(const std::uint8_t*& cursor, const std::uint8_t* end, std::uint32_t& count)
{
  std::uint64_t value = 0;
  for (unsigned index = 0; index < LongestCount && cursor != end; ++index)
  {
    const std::uint8_t byte = *cursor++;
    value |= static_cast<std::uint64_t>(byte & 0x7fU) << (7U * index);
    if (byte < 0x80U)
    {
      count = static_cast<std::uint32_t>(value);
      return value <= std::numeric_limits<std::uint32_t>::max();
    }
  }
  return false;
}

// What a pass over the part finds out about its active pixels.
struct Summary
{
  std::vector<PixelRun> Runs;
  std::size_t Count = 0;
  std::uint32_t LowestDepth = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t HighestDepth = 0;
  std::uint32_t CommonAlpha = AlphaBits; // all ones if every alpha is 255
};

Summary Summarize(const ImageView& picture, const PixelRectangle& part)
{
  Summary summary;
  for (int y = part.Y; y < part.GetTop(); ++y)
  {
    const std::size_t row = picture.GetIndex(part.X, y);
    const float* depths = picture.Depths + row;
    const std::uint32_t* colors = picture.Colors + row;
    for (int begin = FindActive(depths, 0, part.Width); begin < part.Width;)
    {
      const int end = FindInactive(depths, begin, part.Width);
      for (int x = begin; x < end; ++x)
      {
        const std::uint32_t bits = GetBits(depths[x]);
        summary.LowestDepth = std::min(summary.LowestDepth, bits);
        summary.HighestDepth = std::max(summary.HighestDepth, bits);
        summary.CommonAlpha &= colors[x];
      }
      summary.Runs.push_back({ part.X + begin, y, end - begin, summary.Count });
      summary.Count += static_cast<std::size_t>(end - begin);
      begin = FindActive(depths, end, part.Width);
    }
  }
  return summary;
}

std::uint8_t ChooseDepthSize(const Summary& summary)
{
  const std::uint32_t range = summary.Count == 0 ? 0 : summary.HighestDepth - summary.LowestDepth;
  return range < (1U << 16U) ? 2 : range < (1U << 24U) ? 3 : 4;
}

// Stores the `size` low bytes of values as `at` advances. Four bytes are written each time, which
// the next value overwrites; so the buffer is to have four bytes more than the values take.
template <typename Value>
std::uint8_t* PackValues(std::size_t size, int count, const Value& value, std::uint8_t* at)
{
  for (int index = 0; index < count; ++index)
  {
    StoreLittleEndian<std::uint32_t>(at, value(index));
    at += size;
  }
  return at;
}

void AppendRunLengths(const Summary& summary, const PixelRectangle& part, Message& bytes)
{
  std::uint32_t end = 0;
  std::uint32_t inactive = 0;
  std::uint32_t active = 0;
  for (const PixelRun& run : summary.Runs)
  {
    const std::uint32_t begin =
      static_cast<std::uint32_t>(run.Y - part.Y) * static_cast<std::uint32_t>(part.Width) +
      static_cast<std::uint32_t>(run.X - part.X);
    if (begin != end && active != 0)
    {
      AppendCount(inactive, bytes);
      AppendCount(active, bytes);
      inactive = 0;
      active = 0;
    }
    // A run that begins where the row before ended goes on with the one of that row.
    inactive += begin - end;
    active += static_cast<std::uint32_t>(run.Length);
    end = begin + static_cast<std::uint32_t>(run.Length);
  }
  if (active != 0)
  {
    AppendCount(inactive, bytes);
    AppendCount(active, bytes);
  }
}

Status MakeCorruptError(const char* reason)
{
  return { StatusCode::Corrupt, std::string("Pixels from another rank: ") + reason };
}

// Makes runs of rows from the lengths; each lies inside the part.
Status ReadRunLengths(const std::uint8_t*& cursor, const std::uint8_t* end,
  const PixelRectangle& part, std::size_t count, std::vector<PixelRun>& runs)
{
  runs.clear();
  const auto area = static_cast<std::uint64_t>(part.GetArea());
  std::uint64_t position = 0;
  std::size_t first = 0;
  while (first < count)
  {
    std::uint32_t inactive = 0;
    std::uint32_t active = 0;
    if (!ReadCount(cursor, end, inactive) || !ReadCount(cursor, end, active) || active == 0 ||
      active > count - first || position + inactive + active > area)
    {
      return MakeCorruptError("runs that do not fit their rectangle");
    }
    position += inactive;
    while (active > 0)
    {
      const auto x = static_cast<int>(position % static_cast<std::uint64_t>(part.Width));
      const auto y = static_cast<int>(position / static_cast<std::uint64_t>(part.Width));
      const int length = std::min(static_cast<int>(active), part.Width - x);
      runs.push_back({ part.X + x, part.Y + y, length, first });
      first += static_cast<std::size_t>(length);
      position += static_cast<std::uint64_t>(length);
      active -= static_cast<std::uint32_t>(length);
    }
  }
  return Status::Ok();
}

// Loads values of `size` (2 to 4) bytes each: four at a time, but for the last value, behind which
// there may be nothing.
template <typename Function>
void UnpackValues(const std::uint8_t* at, std::size_t size, std::size_t count, const Function& use)
{
  if (count == 0)
  {
    return;
  }
  const std::uint32_t mask = 0xffffffffU >> (32U - 8U * static_cast<unsigned>(size));
  std::size_t index = 0;
  for (; index + 2 < count; ++index, at += size)
  {
    use(index, LoadLittleEndian<std::uint32_t>(at) & mask);
  }
  for (; index < count; ++index, at += size)
  {
    std::uint32_t value = 0;
    std::memcpy(&value, at, size);
    use(index, value);
  }
}

} // namespace

int FindActive(const float* depths, int begin, int end)
{
  constexpr int Block = 32;
  int x = begin;
  for (; x + Block <= end; x += Block)
  {
    int active = 0; // without a branch for each pixel
    for (int index = 0; index < Block; ++index)
    {
      active |= depths[x + index] < 1.0F ? 1 : 0;
    }
    if (active != 0)
    {
      break;
    }
  }
  while (x < end && !(depths[x] < 1.0F))
  {
    ++x;
  }
  return x;
}

int FindInactive(const float* depths, int begin, int end)
{
  int x = begin;
  while (x < end && depths[x] < 1.0F)
  {
    ++x;
  }
  return x;
}

void AppendActivePixels(
  const ImageView& picture, const PixelRectangle& part, PixelContent content, Message& bytes)
{
  const Summary summary = Summarize(picture, part);
  const std::uint8_t colorSize = summary.CommonAlpha == AlphaBits ? 3 : 4;
  const std::uint8_t depthSize =
    content == PixelContent::Colors ? std::uint8_t{ 0 } : ChooseDepthSize(summary);

  const std::size_t begin = bytes.size();
  bytes.resize(begin + HeaderSize);
  AppendRunLengths(summary, part, bytes);
  const std::size_t pixels = bytes.size();
  const std::size_t end = pixels + summary.Count * (std::size_t{ colorSize } + depthSize);
  bytes.resize(end + sizeof(std::uint32_t));

  std::uint8_t* at = bytes.data() + pixels;
  for (const PixelRun& run : summary.Runs)
  {
    const std::uint32_t* colors = picture.Colors + picture.GetIndex(run.X, run.Y);
    at = PackValues(
      colorSize, run.Length, [colors](int index) { return colors[index]; }, at);
  }
  for (const PixelRun& run : summary.Runs)
  {
    const float* depths = picture.Depths + picture.GetIndex(run.X, run.Y);
    at = PackValues(
      depthSize, depthSize == 0 ? 0 : run.Length,
      [depths, &summary](int index) { return GetBits(depths[index]) - summary.LowestDepth; }, at);
  }
  bytes.resize(end);

  std::uint8_t* header = bytes.data() + begin;
  StoreLittleEndian(header, static_cast<std::uint32_t>(end - begin - sizeof(std::uint32_t)));
  StoreLittleEndian(header + 4, static_cast<std::uint32_t>(summary.Count));
  header[8] = colorSize;
  header[9] = depthSize;
  StoreLittleEndian(header + 10, summary.Count == 0 ? 0 : summary.LowestDepth);
}

Status ReadActivePixels(const Message& bytes, const PixelRectangle& part, PixelContent content,
  std::size_t& offset, ActivePixels& pixels)
{
  if (offset > bytes.size() || bytes.size() - offset < HeaderSize)
  {
    return MakeCorruptError("truncated header");
  }
  const std::uint8_t* header = bytes.data() + offset;
  const std::size_t size = LoadLittleEndian<std::uint32_t>(header) + sizeof(std::uint32_t);
  const std::size_t count = LoadLittleEndian<std::uint32_t>(header + 4);
  const std::size_t colorSize = header[8];
  const std::size_t depthSize = header[9];
  const auto lowest = LoadLittleEndian<std::uint32_t>(header + 10);
  if (size < HeaderSize || size > bytes.size() - offset)
  {
    return MakeCorruptError("truncated");
  }
  if (colorSize < 3 || colorSize > 4 || depthSize == 1 || depthSize > 4 ||
    (depthSize == 0) != (content == PixelContent::Colors) ||
    count > static_cast<std::uint64_t>(part.GetArea()))
  {
    return MakeCorruptError("a header that nobody writes");
  }

  const std::uint8_t* cursor = header + HeaderSize;
  const std::uint8_t* end = header + size;
  ISOSURFACE_RETURN_IF_ERROR(ReadRunLengths(cursor, end, part, count, pixels.Runs));
  if (static_cast<std::size_t>(end - cursor) != count * (colorSize + depthSize))
  {
    return MakeCorruptError("colors and depths of another number of pixels");
  }
  pixels.Colors.resize(count);
  const std::uint32_t alpha = colorSize == 3 ? AlphaBits : 0;
  UnpackValues(cursor, colorSize, count,
    [&](std::size_t index, std::uint32_t value) { pixels.Colors[index] = value | alpha; });
  pixels.Depths.resize(depthSize == 0 ? 0 : count);
  if (depthSize != 0)
  {
    UnpackValues(cursor + count * colorSize, depthSize, count,
      [&](std::size_t index, std::uint32_t value)
      { pixels.Depths[index] = MakeDepth(lowest + value); });
  }
  offset += size;
  return Status::Ok();
}

} // namespace isosurface
