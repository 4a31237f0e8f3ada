// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/SampleCopy.h"

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

SampleView MakeSampleView(
  ValueType type, const VertexBox& box, const void* first, std::int64_t components)
{
  const Index3 size = box.GetSize();
  return { type, first, { components, components * size[0], components * size[0] * size[1] }, box,
    box };
}

SampleView Coarsen(const SampleView& view, int level)
{
  const std::int64_t step = std::int64_t{ 1 } << level;
  const auto coarsen = [step](VertexBox box)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      box.Low[axis] = (box.Low[axis] + step - 1) / step;
      box.High[axis] = (box.High[axis] + step - 1) / step;
    }
    return box;
  };
  SampleView coarse = view;
  coarse.Available = coarsen(view.Available);
  coarse.Box = coarsen(view.Box);
  const Index3& low = coarse.Available.Low;
  if (!coarse.Available.IsEmpty())
  {
    coarse.First = view.AtBytes({ low[0] * step, low[1] * step, low[2] * step });
  }
  for (std::ptrdiff_t& stride : coarse.Stride)
  {
    stride *= static_cast<std::ptrdiff_t>(step);
  }
  return coarse;
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

void CopyBox(const SampleView& from, const VertexBox& part, const VertexBox& whole, void* to,
  std::ptrdiff_t stride)
{
  if (part.IsEmpty())
  {
    return;
  }
  const std::size_t size = GetValueSize(from.Type);
  VisitRows(part,
    [&](const Index3& first, std::int64_t count)
    {
      const auto place = static_cast<std::ptrdiff_t>(whole.FindIndex(first)) * stride;
      CopySamples(static_cast<std::uint8_t*>(to) + place * static_cast<std::ptrdiff_t>(size),
        stride, from.AtBytes(first), from.Stride[0], count, size);
    });
}

} // namespace isosurface
