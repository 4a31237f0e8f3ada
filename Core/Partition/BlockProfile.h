// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockProfile_h
#define isosurface_BlockProfile_h

#include "Volume/ValueType.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace isosurface
{

/// The least and the greatest finite value of some samples; empty when Low > High.
struct ValueSpan
{
  double Low = std::numeric_limits<double>::infinity();
  double High = -std::numeric_limits<double>::infinity();

  void Add(const ValueSpan& other)
  {
    this->Low = other.Low < this->Low ? other.Low : this->Low;
    this->High = other.High > this->High ? other.High : this->High;
  }
};

/**
 * How many small cubes of a block (CubeSize vertices a side) an isosurface passes, by isovalue: a
 * cheap estimate of the block's spectrum of triangles, known after one look at the samples.
 *
 * Counted at isovalues that are multiples of 2^Exponent, the least exponent for which Span has at
 * most MaximumCount of them (for integers not below 0). So a block's profile is the same, whatever
 * parts it was made of, in whatever order.
 */
struct BlockProfile
{
  static constexpr std::int64_t CubeSize = 4;
  static constexpr std::size_t MaximumCount = 32;

  ValueSpan Span; ///< of the cubes that are not constant
  std::int32_t Exponent = 0;
  std::int64_t First = 0;                           ///< Counts[n] is at (First + n) * 2^Exponent
  std::array<std::uint16_t, MaximumCount> Counts{}; ///< 0 beyond Span

  /// The profile of these cubes, each the span of its samples.
  static BlockProfile Make(ValueType type, const std::vector<ValueSpan>& cubes);

  /// Adds the cubes of another part of the block.
  void Add(ValueType type, const BlockProfile& other);

  bool IsEmpty() const { return this->Span.Low >= this->Span.High; }

  /// The count at the last of the isovalues that is <= `isovalue`; 0 outside of Span.
  std::uint32_t GetCount(double isovalue) const;

private:
  void ChooseBins(ValueType type);
  void Coarsen(std::int32_t exponent);
};

} // namespace isosurface

#endif
