// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Distribution/BlockProfile.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

/// The minimum n with n * 2^exponent > value.
std::int64_t FindFirstAbove(double value, std::int32_t exponent)
{
  return static_cast<std::int64_t>(std::floor(std::ldexp(value, -exponent))) + 1;
}

bool IsInteger(ValueType type)
{
  return DispatchValueType(
    type, [](auto zero) { return std::numeric_limits<decltype(zero)>::is_integer; });
}

} // namespace

BlockProfile BlockProfile::Make(ValueType type, const std::vector<SampleSpan>& cubes)
{
  BlockProfile profile;
  for (const SampleSpan& cube : cubes)
  {
    if (cube.Low < cube.High)
    {
      profile.Span.Add(cube);
    }
  }
  if (profile.IsEmpty())
  {
    return profile;
  }
  profile.ChooseBins(type);
  std::array<std::int32_t, MaximumCount + 1> changes{};
  for (const SampleSpan& cube : cubes)
  {
    if (cube.Low < cube.High)
    {
      const auto begin = FindFirstAbove(cube.Low, profile.Exponent) - profile.First;
      const auto end = FindFirstAbove(cube.High, profile.Exponent) - profile.First;
      ++changes[static_cast<std::size_t>(begin)];
      --changes[static_cast<std::size_t>(end)];
    }
  }
  std::int32_t count = 0;
  for (std::size_t bin = 0; bin < MaximumCount; ++bin)
  {
    count += changes[bin];
    profile.Counts[bin] = static_cast<std::uint16_t>(count);
  }
  return profile;
}

/// Sets Exponent and First from Span.
void BlockProfile::ChooseBins(ValueType type)
{
  // Halved, since the difference of two doubles may overflow.
  const double half = 0.5 * this->Span.High - 0.5 * this->Span.Low;
  this->Exponent = half > 0 ? std::ilogb(half) - 5 : std::numeric_limits<double>::min_exponent - 53;
  // With smaller exponents, the multiples would not fit 64 bits.
  const double magnitude = std::max(std::abs(this->Span.Low), std::abs(this->Span.High));
  this->Exponent = std::max(this->Exponent, std::ilogb(magnitude) - 60);
  this->Exponent = IsInteger(type) ? std::max(this->Exponent, 0) : this->Exponent;
  for (;; ++this->Exponent)
  {
    this->First = FindFirstAbove(this->Span.Low, this->Exponent);
    const std::int64_t end = FindFirstAbove(this->Span.High, this->Exponent);
    if (end - this->First <= static_cast<std::int64_t>(MaximumCount))
    {
      return;
    }
  }
}

/// Keeps only the counts at multiples of 2^exponent.
void BlockProfile::Coarsen(std::int32_t exponent)
{
  for (; this->Exponent < exponent; ++this->Exponent)
  {
    const bool isOdd = (this->First & 1) != 0;
    this->First = (this->First >> 1) + (isOdd ? 1 : 0);
    for (std::size_t bin = 0; bin < MaximumCount; ++bin)
    {
      const std::size_t source = 2 * bin + (isOdd ? 1 : 0);
      this->Counts[bin] = source < MaximumCount ? this->Counts[source] : std::uint16_t{ 0 };
    }
  }
}

void BlockProfile::Add(ValueType type, const BlockProfile& other)
{
  if (other.IsEmpty())
  {
    return;
  }
  if (this->IsEmpty())
  {
    *this = other;
    return;
  }
  BlockProfile sum;
  sum.Span = this->Span;
  sum.Span.Add(other.Span);
  sum.ChooseBins(type);
  for (BlockProfile part : { *this, other })
  {
    part.Coarsen(sum.Exponent);
    for (std::size_t bin = 0; bin < MaximumCount; ++bin)
    {
      // Bins outside the sum's have the count 0, since they are outside the part's span.
      const std::int64_t target = part.First + static_cast<std::int64_t>(bin) - sum.First;
      if (part.Counts[bin] != 0)
      {
        auto& count = sum.Counts[static_cast<std::size_t>(target)];
        count = static_cast<std::uint16_t>(count + part.Counts[bin]);
      }
    }
  }
  *this = sum;
}

std::uint32_t BlockProfile::GetCount(double isovalue) const
{
  const double bin =
    std::floor(std::ldexp(isovalue, -this->Exponent)) - static_cast<double>(this->First);
  return bin >= 0 && bin < static_cast<double>(MaximumCount)
    ? this->Counts[static_cast<std::size_t>(bin)]
    : 0;
}

} // namespace isosurface
