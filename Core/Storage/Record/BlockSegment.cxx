// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/BlockSegment.h"

#include <cstring>

namespace isosurface
{
namespace
{

// There is no padding between segments, so samples may be unaligned.

template <typename T>
void CopyStrided(void* to, std::ptrdiff_t toStride, const void* from, std::ptrdiff_t fromStride,
  std::int64_t count)
{
  auto* target = static_cast<std::uint8_t*>(to);
  const auto* source = static_cast<const std::uint8_t*>(from);
  constexpr auto size = static_cast<std::ptrdiff_t>(sizeof(T));
  if (toStride == 1 && fromStride == 2)
  {
    for (std::int64_t sample = 0; sample < count; ++sample) // the compiler vectorises this one
    {
      std::memcpy(target + sample * size, source + sample * 2 * size, sizeof(T));
    }
    return;
  }
  for (std::int64_t sample = 0; sample < count; ++sample)
  {
    std::memcpy(target + sample * toStride * size, source + sample * fromStride * size, sizeof(T));
  }
}

/// Copies a few bytes, without a call where there are at least 16.
void CopyBytes(std::uint8_t* to, const std::uint8_t* from, std::size_t size)
{
  constexpr std::size_t step = 16;
  if (size < step || size > 16 * step)
  {
    std::memcpy(to, from, size);
    return;
  }
  for (std::size_t at = 0; at + step <= size; at += step)
  {
    std::memcpy(to + at, from + at, step);
  }
  std::memcpy(to + size - step, from + size - step, step);
}

} // namespace

std::uint64_t BlockSegment::GetNumberOfSamples() const
{
  auto samples = static_cast<std::uint64_t>(this->Box.GetNumberOfVertices());
  if (!this->IsWhole)
  {
    std::uint64_t even = 1;
    for (int axis = 0; axis < 3; ++axis)
    {
      even *= static_cast<std::uint64_t>(
        ((this->Box.High[axis] + 1) >> 1) - ((this->Box.Low[axis] + 1) >> 1));
    }
    samples -= even;
  }
  return samples;
}

void CopySamples(void* to, std::ptrdiff_t toStride, const void* from, std::ptrdiff_t fromStride,
  std::int64_t count, std::size_t size)
{
  if (toStride == 1 && fromStride == 1)
  {
    CopyBytes(static_cast<std::uint8_t*>(to), static_cast<const std::uint8_t*>(from),
      static_cast<std::size_t>(count) * size);
    return;
  }
  switch (size)
  {
    case 1:
      return CopyStrided<std::uint8_t>(to, toStride, from, fromStride, count);
    case 2:
      return CopyStrided<std::uint16_t>(to, toStride, from, fromStride, count);
    case 4:
      return CopyStrided<std::uint32_t>(to, toStride, from, fromStride, count);
    default:
      return CopyStrided<std::uint64_t>(to, toStride, from, fromStride, count);
  }
}

VertexBox CoarsenBox(const VertexBox& box, int level)
{
  VertexBox coarse;
  const std::int64_t round = (std::int64_t{ 1 } << level) - 1;
  for (int axis = 0; axis < 3; ++axis)
  {
    coarse.Low[axis] = (box.Low[axis] + round) >> level;
    coarse.High[axis] = (box.High[axis] + round) >> level;
  }
  return coarse;
}

} // namespace isosurface
