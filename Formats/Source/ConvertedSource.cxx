// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/ConvertedSource.h"

#include "Ground/Volume/CutToRange.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace isosurface
{

ValueType FindScaledType(ValueType stored)
{
  return stored == ValueType::Float32 || GetValueSize(stored) <= 2 ? ValueType::Float32
                                                                   : ValueType::Float64;
}

void ScaleSamples(ValueType stored, const void* from, std::size_t count, SampleScale scale,
  ValueType type, void* to)
{
  DispatchValueType(stored,
    [&](auto some)
    {
      DispatchValueType(type,
        [&](auto zero)
        {
          using From = decltype(some);
          using To = decltype(zero);
          const auto* begin = static_cast<const From*>(from);
          std::transform(begin, begin + count, static_cast<To*>(to),
            [scale](From value)
            { return CutToRange<To>(scale.Slope * static_cast<double>(value) + scale.Intercept); });
        });
    });
}

float WidenHalf(std::uint16_t bits)
{
  const std::uint32_t sign = static_cast<std::uint32_t>(bits & 0x8000) << 16;
  const std::uint32_t exponent = (bits >> 10) & 0x1f;
  const std::uint32_t fraction = bits & 0x3ff;
  float value = 0;
  if (exponent == 0)
  {
    value = static_cast<float>(fraction) * 0x1p-24F;
    return sign != 0 ? -value : value;
  }
  const std::uint32_t widened = exponent == 31 ? 255 : exponent + 112;
  const std::uint32_t single = sign | (widened << 23) | (fraction << 13);
  std::memcpy(&value, &single, sizeof(value));
  return value;
}

ConvertedSource::ConvertedSource(
  std::unique_ptr<BoxSource> source, ValueType stored, SampleScale scale, ValueType type)
  : Source(std::move(source))
  , Stored(stored)
  , Scale(scale)
  , Type(type)
  , Pool(std::make_shared<PageBufferPool>())
{
}

ConvertedSource::ConvertedSource(std::unique_ptr<BoxSource> halves)
  : ConvertedSource(std::move(halves), ValueType::UInt16, {}, ValueType::Float32)
{
  this->IsHalf = true;
}

std::uint64_t ConvertedSource::GetReadBytes(const VertexBox& box) const
{
  return this->Source->GetReadBytes(box) +
    static_cast<std::uint64_t>(box.GetNumberOfVertices()) * GetValueSize(this->Type);
}

Result<BoxSamples> ConvertedSource::Read(const VertexBox& box)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto stored, this->Source->Read(box));
  ISOSURFACE_ASSIGN_OR_RETURN(auto samples,
    this->Pool->Take(
      static_cast<std::uint64_t>(box.GetNumberOfVertices()) * GetValueSize(this->Type)));
  // Rows without gaps are converted at once.
  const SampleView& view = stored.Arrays.front();
  std::uint8_t* to = samples->GetData();
  const std::int64_t run = view.Stride[0] == 1 ? box.GetSize()[0] : 1;
  const auto count = static_cast<std::size_t>(run);
  for (std::int64_t k = box.Low[2]; k < box.High[2]; ++k)
  {
    for (std::int64_t j = box.Low[1]; j < box.High[1]; ++j)
    {
      for (std::int64_t i = box.Low[0]; i < box.High[0]; i += run)
      {
        const void* from = view.AtBytes({ i, j, k });
        if (this->IsHalf)
        {
          const auto* halves = static_cast<const std::uint16_t*>(from);
          std::transform(halves, halves + count, reinterpret_cast<float*>(to), WidenHalf);
        }
        else
        {
          ScaleSamples(this->Stored, from, count, this->Scale, this->Type, to);
        }
        to += count * GetValueSize(this->Type);
      }
    }
  }
  return MakeBoxSamples(this->Type, box, std::move(samples));
}

} // namespace isosurface
