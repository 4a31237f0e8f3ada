// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CrossingIntervals_h
#define isosurface_CrossingIntervals_h

#include <cstdint>
#include <limits>

namespace isosurface
{

/// The equal intervals of an edge; which of them has the crossing is coded, and the point is placed in
/// its middle. A parameter is a place on the edge: 0 at its first vertex, 1 at its second.
class CrossingIntervals
{
public:
  /// No intervals.
  CrossingIntervals() = default;

  static CrossingIntervals MakeEqual(std::uint32_t count)
  {
    CrossingIntervals intervals;
    intervals.Count = count;
    intervals.Reciprocal = (std::uint64_t{ 1 } << 40) / count;
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
    const double position = parameter * this->Count;
    return position <= 0        ? 0
      : position >= this->Count ? this->Count - 1
                                : static_cast<std::uint32_t>(position);
  }

  /// The parameter in the middle of an interval.
  double GetMiddle(std::uint32_t interval) const { return (interval + 0.5) / this->Count; }

  /// The same as it is decoded; NaN for the number of intervals.
  float GetPlace(std::uint32_t interval) const
  {
    return interval == this->Count ? std::numeric_limits<float>::quiet_NaN()
                                   : static_cast<float>(this->GetMiddle(interval));
  }

  /// The middle in units of 2^-10 (CrossingFit::Unit), rounded down.
  std::int16_t GetPosition(std::uint32_t interval) const
  {
    return static_cast<std::int16_t>((2 * std::uint64_t{ interval } + 1) * this->Reciprocal >> 31);
  }

  /// Where a parameter, in units of 2^-16, lies among the intervals: the number of the interval and
  /// the place in it, in units of 2^-16 of an interval.
  std::int64_t Locate(std::int32_t parameter) const
  {
    return std::int64_t{ parameter } * this->Count;
  }

private:
  std::uint32_t Count = 0;
  std::uint64_t Reciprocal = 0; ///< 2^40 / Count
};

} // namespace isosurface

#endif
