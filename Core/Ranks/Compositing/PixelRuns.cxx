// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/PixelRuns.h"

#include "Ground/Base/Coding.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace isosurface
{
namespace
{

constexpr std::size_t HeaderSize = 14;
constexpr std::uint32_t AlphaBits = 0xff000000U; // of a color that was loaded little-endian

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

// What the passes over the depths find out about the active pixels.
struct Summary
{
  std::vector<PixelRun> Runs;
  std::size_t Count = 0;
  std::uint32_t MinimumDepth = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t MaximumDepth = 0;
  std::uint32_t CommonAlpha = AlphaBits; // unchanged if every alpha is 255
};

Summary Summarize(const ImageView& image, const PixelRectangle& rectangle)
{
  Summary summary;
  ForEachActiveRun(image, rectangle,
    [&summary](const PixelRun& run, const std::uint32_t* colors, const float* depths)
    {
      for (int x = 0; x < run.Length; ++x)
      {
        const std::uint32_t bits = GetBits(depths[x]);
        summary.MinimumDepth = std::min(summary.MinimumDepth, bits);
        summary.MaximumDepth = std::max(summary.MaximumDepth, bits);
        summary.CommonAlpha &= colors[x];
      }
      summary.Runs.push_back(run);
      summary.Count += static_cast<std::size_t>(run.Length);
    });
  return summary;
}

std::uint8_t ChooseDepthSize(const Summary& summary)
{
  const std::uint32_t range = summary.Count == 0 ? 0 : summary.MaximumDepth - summary.MinimumDepth;
  return range < (1U << 16U) ? 2 : range < (1U << 24U) ? 3 : 4;
}

// Stores the `size` low bytes of values, and returns their end. Each value is written as four bytes,
// the next one overwrites what exceeds it; so the buffer has four bytes more than the values take.
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

void AppendRunLengths(const Summary& summary, const PixelRectangle& rectangle, Message& bytes)
{
  std::uint32_t end = 0;
  std::uint32_t inactive = 0;
  std::uint32_t active = 0;
  for (const PixelRun& run : summary.Runs)
  {
    const std::uint32_t begin = static_cast<std::uint32_t>(run.Y - rectangle.Y) *
        static_cast<std::uint32_t>(rectangle.Width) +
      static_cast<std::uint32_t>(run.X - rectangle.X);
    if (begin != end && active != 0)
    {
      AppendVarint(bytes, inactive);
      AppendVarint(bytes, active);
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
    AppendVarint(bytes, inactive);
    AppendVarint(bytes, active);
  }
}

Status MakeCorruptError(const char* reason)
{
  return { StatusCode::Corrupt, std::string("Pixels from another rank: ") + reason };
}

// Makes runs of rows from the lengths; each lies inside the rectangle.
Status ReadRunLengths(ByteReader& reader, const PixelRectangle& rectangle, std::size_t count,
  std::vector<PixelRun>& runs)
{
  runs.clear();
  const auto area = static_cast<std::uint64_t>(rectangle.GetArea());
  std::uint64_t position = 0;
  std::size_t first = 0;
  while (first < count)
  {
    const auto inactive = reader.ReadVarint<std::uint32_t>();
    auto active = reader.ReadVarint<std::uint32_t>();
    if (reader.HasFailed() || active == 0 || active > count - first ||
      position + inactive + active > area)
    {
      return MakeCorruptError("runs that do not fit their rectangle");
    }
    position += inactive;
    while (active > 0)
    {
      const auto x = static_cast<int>(position % static_cast<std::uint64_t>(rectangle.Width));
      const auto y = static_cast<int>(position / static_cast<std::uint64_t>(rectangle.Width));
      const int length = std::min(static_cast<int>(active), rectangle.Width - x);
      runs.push_back({ rectangle.X + x, rectangle.Y + y, length, first });
      first += static_cast<std::size_t>(length);
      position += static_cast<std::uint64_t>(length);
      active -= static_cast<std::uint32_t>(length);
    }
  }
  return Status::Ok();
}

// Loads values of `size` (2 to 4) bytes each. All but the last two are loaded as four bytes at once.
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
  const ImageView& image, const PixelRectangle& rectangle, PixelContent content, Message& bytes)
{
  const Summary summary = Summarize(image, rectangle);
  const std::uint8_t colorSize = summary.CommonAlpha == AlphaBits ? 3 : 4;
  const std::uint8_t depthSize =
    content == PixelContent::Colors ? std::uint8_t{ 0 } : ChooseDepthSize(summary);

  const std::size_t begin = bytes.size();
  bytes.resize(begin + HeaderSize);
  AppendRunLengths(summary, rectangle, bytes);
  const std::size_t pixels = bytes.size();
  const std::size_t end = pixels + summary.Count * (std::size_t{ colorSize } + depthSize);
  bytes.resize(end + sizeof(std::uint32_t));

  std::uint8_t* at = bytes.data() + pixels;
  for (const PixelRun& run : summary.Runs)
  {
    const std::uint32_t* colors = image.Colors + image.GetIndex(run.X, run.Y);
    at = PackValues(
      colorSize, run.Length, [colors](int index) { return colors[index]; }, at);
  }
  for (const PixelRun& run : summary.Runs)
  {
    const float* depths = image.Depths + image.GetIndex(run.X, run.Y);
    at = PackValues(
      depthSize, depthSize == 0 ? 0 : run.Length,
      [depths, &summary](int index) { return GetBits(depths[index]) - summary.MinimumDepth; }, at);
  }
  bytes.resize(end);

  std::uint8_t* header = bytes.data() + begin;
  StoreLittleEndian(header, static_cast<std::uint32_t>(end - begin - sizeof(std::uint32_t)));
  StoreLittleEndian(header + 4, static_cast<std::uint32_t>(summary.Count));
  header[8] = colorSize;
  header[9] = depthSize;
  StoreLittleEndian(header + 10, summary.Count == 0 ? 0 : summary.MinimumDepth);
}

Status ReadActivePixels(const Message& bytes, const PixelRectangle& rectangle, PixelContent content,
  std::size_t& offset, ActivePixels& pixels)
{
  if (offset > bytes.size() || bytes.size() - offset < HeaderSize)
  {
    return MakeCorruptError("truncated header");
  }
  const std::uint8_t* begin = bytes.data() + offset;
  const std::size_t size = LoadLittleEndian<std::uint32_t>(begin) + sizeof(std::uint32_t);
  if (size < HeaderSize || size > bytes.size() - offset)
  {
    return MakeCorruptError("truncated");
  }
  ByteReader reader(begin + sizeof(std::uint32_t), size - sizeof(std::uint32_t));
  const std::size_t count = reader.Read<std::uint32_t>();
  const std::size_t colorSize = reader.Read<std::uint8_t>();
  const std::size_t depthSize = reader.Read<std::uint8_t>();
  const auto minimumDepth = reader.Read<std::uint32_t>();
  if (colorSize < 3 || colorSize > 4 || depthSize == 1 || depthSize > 4 ||
    (depthSize == 0) != (content == PixelContent::Colors) ||
    count > static_cast<std::uint64_t>(rectangle.GetArea()))
  {
    return MakeCorruptError("impossible sizes in the header");
  }

  ISOSURFACE_RETURN_IF_ERROR(ReadRunLengths(reader, rectangle, count, pixels.Runs));
  if (reader.GetRemaining() != count * (colorSize + depthSize))
  {
    return MakeCorruptError("colors and depths of another number of pixels");
  }
  pixels.Colors.resize(count);
  const std::uint32_t alpha = colorSize == 3 ? AlphaBits : 0;
  UnpackValues(reader.ReadBytes(count * colorSize), colorSize, count,
    [&](std::size_t index, std::uint32_t value) { pixels.Colors[index] = value | alpha; });
  pixels.Depths.resize(depthSize == 0 ? 0 : count);
  if (depthSize != 0)
  {
    UnpackValues(reader.ReadBytes(count * depthSize), depthSize, count,
      [&](std::size_t index, std::uint32_t value)
      { pixels.Depths[index] = MakeDepth(minimumDepth + value); });
  }
  offset += size;
  return Status::Ok();
}

} // namespace isosurface
