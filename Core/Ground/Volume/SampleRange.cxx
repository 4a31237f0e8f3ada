// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/SampleRange.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace isosurface
{
namespace
{

template <typename T, bool OnlyFinite>
class RangeOf
{
public:
  void AddRow(const T* row, std::int64_t count, std::ptrdiff_t stride)
  {
    if (stride == 1)
    {
      this->AddSamples(row, count, 1); // the compiler vectorises this call
    }
    else
    {
      this->AddSamples(row, count, stride);
    }
  }
  bool HasInfinity() const
  {
    return std::is_floating_point_v<T> &&
      (std::isinf(static_cast<double>(this->Low)) || std::isinf(static_cast<double>(this->High)));
  }
  bool IsEmpty() const { return this->Low > this->High; }
  bool HasNaN() const { return this->NaN; }
  KeyRange GetKeys() const
  {
    return this->IsEmpty() ? KeyRange{}
                           : KeyRange{ MakeValueKey(this->Low), MakeValueKey(this->High) };
  }

private:
  using Limits = std::numeric_limits<T>;

  void AddSamples(const T* row, std::int64_t count, std::ptrdiff_t stride)
  {
    T low = this->Low;
    T high = this->High;
    bool nan = false;
    for (std::int64_t i = 0; i < count; ++i)
    {
      const T value = row[i * stride];
      if constexpr (OnlyFinite)
      {
        if (!std::isfinite(value))
        {
          continue;
        }
      }
      // The comparisons are false for NaN, so a NaN changes nothing.
      low = value < low ? value : low;
      high = value > high ? value : high;
      if constexpr (std::is_floating_point_v<T>)
      {
        nan |= value != value;
      }
    }
    this->Low = low;
    this->High = high;
    this->NaN |= nan;
  }

  T Low = Limits::has_infinity ? Limits::infinity() : Limits::max();
  T High = Limits::has_infinity ? -Limits::infinity() : Limits::lowest();
  bool NaN = false;
};

template <typename T, bool OnlyFinite>
RangeOf<T, OnlyFinite> FindRange(const SampleView& samples, const VertexBox& box)
{
  RangeOf<T, OnlyFinite> range;
  VisitRows(box,
    [&](const Index3& first, std::int64_t count)
    { range.AddRow(samples.At<T>(first), count, samples.Stride[0]); });
  return range;
}

} // namespace

void SampleRange::Add(const SampleRange& other)
{
  this->All.Add(other.All);
  this->Finite.Add(other.Finite);
}

SampleRange FindSampleRange(const SampleView& samples, const VertexBox& box)
{
  return DispatchValueType(samples.Type,
    [&](auto zero)
    {
      using T = decltype(zero);
      SampleRange result;
      const auto range = FindRange<T, false>(samples, box);
      result.All = range.GetKeys();
      result.Finite = result.All;
      if constexpr (std::is_floating_point_v<T>)
      {
        // If all samples are NaN, Low and High still have their initial, infinite values.
        if (range.HasInfinity())
        {
          result.Finite = FindRange<T, true>(samples, box).GetKeys();
        }
        if (range.HasNaN())
        {
          result.All.Add({ NotANumberKey, NotANumberKey });
        }
      }
      return result;
    });
}

std::vector<ValueKey> FindThresholdKeys(ValueType type, const std::vector<double>& isovalues)
{
  std::vector<ValueKey> keys;
  DispatchValueType(type,
    [&](auto zero)
    {
      for (const double isovalue : isovalues)
      {
        if (const auto threshold = FindThreshold<decltype(zero)>(isovalue))
        {
          keys.push_back(MakeValueKey(*threshold));
        }
      }
    });
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

void CommonRanges::Add(KeyRange& range)
{
  this->Ranges.push_back(&range);
  this->Minima.push_back(range.Minimum);
  this->Maxima.push_back(range.Maximum);
}

void CommonRanges::Join(Communicator& ranks)
{
  ranks.ReduceMinimum(this->Minima);
  ranks.ReduceMaximum(this->Maxima);
  for (std::size_t n = 0; n < this->Ranges.size(); ++n)
  {
    *this->Ranges[n] = { this->Minima[n], this->Maxima[n] };
  }
}

} // namespace isosurface
