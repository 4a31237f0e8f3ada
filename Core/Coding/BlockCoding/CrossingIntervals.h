// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CrossingIntervals_h
#define isosurface_CrossingIntervals_h

#include <algorithm>
#include <cstdint>
#include <limits>

namespace isosurface
{

/// The intervals of an edge; which of them has the crossing is coded, and the point is placed in its
/// middle. Intervals either are equal parts of the edge, or have a given width, the last one ending
/// with the edge. A parameter is a place on the edge: 0 at its first vertex, 1 at its second.
class CrossingIntervals
{
public:
  static constexpr int UnitBits = 30; ///< widths are in units of 2^-30 of an edge

  /// No intervals.
  CrossingIntervals() = default;

  static CrossingIntervals MakeEqual(std::uint32_t count)
  {
    CrossingIntervals intervals;
    intervals.Count = count;
    intervals.Reciprocal = (std::uint64_t{ 1 } << 40) / count;
    return intervals;
  }

  /// width: above 0, at most 2^UnitBits.
  static CrossingIntervals MakeOfWidth(std::uint32_t width)
  {
    CrossingIntervals intervals;
    intervals.Count = ((std::uint32_t{ 1 } << UnitBits) - 1) / width + 1;
    intervals.Width = width;
    intervals.Reciprocal = (std::uint64_t{ 1 } << 46) / width;
    return intervals;
  }

  std::uint32_t GetCount() const { return this->Count; }

  /// The interval that has a parameter; the number of intervals for NaN.
  std::uint32_t Find(double parameter) const
  {
    if (parameter != parameter)
    {
      return this->Count;
    }
    const double position =
      this->Width == 0 ? parameter * this->Count : parameter * (1 << UnitBits) / this->Width;
    return position <= 0        ? 0
      : position >= this->Count ? this->Count - 1
                                : static_cast<std::uint32_t>(position);
  }

  /// The parameter in the middle of an interval.
  double GetMiddle(std::uint32_t interval) const
  {
    return this->Width == 0
      ? (interval + 0.5) / this->Count
      : static_cast<double>(this->AddEnds(interval)) / static_cast<double>(2ull << UnitBits);
  }

  /// The same as it is decoded; NaN for the number of intervals.
  float GetPlace(std::uint32_t interval) const
  {
    return interval == this->Count ? std::numeric_limits<float>::quiet_NaN()
                                   : static_cast<float>(this->GetMiddle(interval));
  }

  /// The middle in units of 2^-10 (CrossingFit::Unit), rounded down.
  std::int16_t GetPosition(std::uint32_t interval) const
  {
    return static_cast<std::int16_t>(this->Width == 0
        ? (2 * std::uint64_t{ interval } + 1) * this->Reciprocal >> 31
        : this->AddEnds(interval) >> (UnitBits + 1 - 10));
  }

  /// Where a parameter, in units of 2^-16, lies among the intervals: the number of the interval and
  /// the place in it, in units of 2^-16 of an interval.
  std::int64_t Locate(std::int32_t parameter) const
  {
    return this->Width == 0
      ? std::int64_t{ parameter } * this->Count
      : static_cast<std::int64_t>(static_cast<std::uint64_t>(parameter) * this->Reciprocal >> 16);
  }

private:
  // The sum of an interval's begin and end.
  std::uint64_t AddEnds(std::uint32_t interval) const
  {
    const std::uint64_t begin = std::uint64_t{ interval } * this->Width;
    return begin + std::min(begin + this->Width, std::uint64_t{ 1 } << UnitBits);
  }

  std::uint32_t Count = 0;
  std::uint32_t Width = 0;      ///< 0 for equal parts
  std::uint64_t Reciprocal = 0; ///< 2^40 / Count, or 2^46 / Width
};

} // namespace isosurface

#endif
