// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockProfile_h
#define isosurface_BlockProfile_h

#include "Ground/Volume/ValueType.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace isosurface
{

/// The range of the finite values of samples; empty if Low > High.
struct SampleSpan
{
  double Low = std::numeric_limits<double>::infinity();
  double High = -std::numeric_limits<double>::infinity();

  void Add(const SampleSpan& other)
  {
    this->Low = other.Low < this->Low ? other.Low : this->Low;
    this->High = other.High > this->High ? other.High : this->High;
  }
};

/**
 * The number of small cubes of a block (CubeSize vertices a side) that an isosurface crosses, by
 * isovalue: a cheap estimate of the block's triangles, computed in one pass over the samples.
 *
 * The isovalues are the multiples of 2^Exponent in Span. Exponent is the minimum for which there
 * are at most MaximumCount of them, but not below 0 for integers. So the profile of a block does
 * not depend on the parts that it was made from, or on their order.
 */
struct BlockProfile
{
  static constexpr std::int64_t CubeSize = 4;
  static constexpr std::size_t MaximumCount = 32;

  SampleSpan Span; ///< of all cubes that are not constant
  std::int32_t Exponent = 0;
  std::int64_t First = 0;                           ///< Counts[n] is at (First + n) * 2^Exponent
  std::array<std::uint16_t, MaximumCount> Counts{}; ///< 0 outside Span

  /// The profile of cubes, given by the ranges of their samples.
  static BlockProfile Make(ValueType type, const std::vector<SampleSpan>& cubes);

  /// Adds the cubes of another part of the block.
  void Add(ValueType type, const BlockProfile& other);

  bool IsEmpty() const { return this->Span.Low >= this->Span.High; }

  /// The count at the last of the profile's isovalues <= `isovalue`; 0 outside Span.
  std::uint32_t GetCount(double isovalue) const;

private:
  void ChooseBins(ValueType type);
  void Coarsen(std::int32_t exponent);
};

} // namespace isosurface

#endif
